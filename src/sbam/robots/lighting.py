"""Light for pictures and films of a composed model."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial.transform import RigidTransform

if TYPE_CHECKING:
    import mujoco

LARGEST_PICTURE = 2048  # pixels


def light(spec: mujoco.MjSpec, T_world_agent: RigidTransform) -> None:
    """A bright background, one lamp that casts shadows and a weaker one from the other side."""
    import mujoco

    spec.visual.global_.offwidth = spec.visual.global_.offheight = LARGEST_PICTURE
    spec.visual.quality.shadowsize = 2048
    spec.visual.headlight.ambient = [0.36, 0.36, 0.36]
    spec.visual.headlight.diffuse = [0.26, 0.26, 0.26]
    spec.visual.headlight.specular = [0.0, 0.0, 0.0]
    spec.add_texture(
        name="sky",
        type=mujoco.mjtTexture.mjTEXTURE_SKYBOX,
        builtin=mujoco.mjtBuiltin.mjBUILTIN_GRADIENT,
        rgb1=[0.97, 0.98, 1.0],
        rgb2=[0.80, 0.84, 0.88],
        width=64,
        height=384,
    )
    for position, diffuse, shadow in (((-1.2, 2.2, 2.6), 0.42, True), ((1.6, -0.8, 2.0), 0.2, False)):
        direction = np.array([0.0, 0.35, 0.1]) - position
        spec.worldbody.add_light(
            type=mujoco.mjtLightType.mjLIGHT_SPOT,
            pos=T_world_agent.apply(position),
            dir=T_world_agent.rotation.apply(direction / np.linalg.norm(direction)),
            cutoff=50,
            exponent=1,
            diffuse=[diffuse] * 3,
            ambient=[0.0] * 3,
            specular=[0.1] * 3,
            castshadow=shadow,
        )
