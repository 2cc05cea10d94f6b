"""Actions that are tried in physics: short ones, so that the tests stay fast."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

from sbam.scene import ObjectLibrary, Scene, upright_rotation
from sbam.simulation.action import Action

LIBRARY = ObjectLibrary.built_in()
RATE = 100.0


@pytest.fixture(scope="session")
def pour():
    """Builds a short pour: the mouth comes to ``aside`` and ``above`` the rim while the bottle tilts, and back."""

    def build(tilt_deg: float = 96.0, aside: float = 0.015, above: float = 0.035, seconds: float = 2.4) -> Action:
        bottle, cup, table = LIBRARY["apple_juice"], LIBRARY["cup_large"], LIBRARY["kitchen_sideboard"]
        time = np.arange(0.0, seconds, 1.0 / RATE)
        course = np.clip(time / 0.8, 0.0, 1.0) * np.clip((seconds - time) / 0.6, 0.0, 1.0)
        turn = Rotation.from_rotvec(np.deg2rad(-tilt_deg) * course[:, None] * [0.0, 1.0, 0.0])
        turn = turn * upright_rotation(bottle.up, 0.0)
        stand = upright_rotation(cup.up, 0.0)
        held = RigidTransform.from_components([0.0, 0.0, 0.2], stand)
        way = np.column_stack([aside + 0.10 * (1.0 - course), 0.0 * course, above + 0.0 * course])
        mouth = held.apply(cup.region("pour into").center) + way
        position = mouth - turn.apply(bottle.region("pour from").center)
        top = upright_rotation(table.up, 0.0)
        scene = Scene(
            name="short pour",
            objects={"cup_large": cup, "apple_juice": bottle, "kitchen_sideboard": table},
            T_world_object={
                "cup_large": held,
                "apple_juice": RigidTransform.from_components(position[0], turn[0]),
                "kitchen_sideboard": RigidTransform.from_components(-top.apply(table.region("place onto").center), top),
            },
            T_world_agent=RigidTransform.identity(),
        )
        return Action(
            name="short pour",
            scene=scene,
            roles={},
            time=time,
            T_world_object={
                "apple_juice": RigidTransform.from_components(position, turn),
                "cup_large": RigidTransform.from_matrix(np.tile(held.as_matrix(), (len(time), 1, 1))),
            },
        )

    return build


@pytest.fixture(scope="session")
def renamed():
    """The same action with other roles."""
    return lambda action, **roles: replace(action, roles=roles)
