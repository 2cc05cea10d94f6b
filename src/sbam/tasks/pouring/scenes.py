"""Random starting scenes of a pour, other than any demonstrated one, before a robot at its default place.

They are the same for every robot, so that robots can be compared; not each of them reaches everything
(`sbam.planning.placement.search.reach_where_it_stands` says by how much).
"""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import RigidTransform

from sbam.demonstrations.synthetic import JUICE_LAYOUTS
from sbam.scene import ObjectLibrary, Scene, upright_rotation
from sbam.tasks.table_scene import scene_on_table

DEMONSTRATED = np.array([[one.distance * np.cos(one.angle), one.distance * np.sin(one.angle)] for one in JUICE_LAYOUTS])
"""Layouts of the demonstrations: bottle relative to cup, (right, forward) m."""
DIFFERENT = 0.03  # m: a layout this far from every demonstrated one is another


def random_pouring_scene(seed: int, bottle: str = "apple_juice", cup: str = "cup_large") -> Scene:
    """A cup and a bottle somewhere on the table before the agent.

    The cup stands up to 25 cm left and 5 cm right of the agent, 36-54 cm ahead; the bottle 18-38 cm from it, to the
    right and between 70 degrees nearer and 70 degrees farther, at most 62 cm ahead; both turned by any angle about the
    vertical that a hand can cope with (a square bottle by up to 30 degrees from the agent's axes).

    Args:
        seed: of the scene.
        bottle: library name of what is poured from.
        cup: library name of what is poured into.
    """
    generator = np.random.default_rng([seed, 1])
    while True:
        cup_at = generator.uniform([-0.25, 0.36], [0.05, 0.54])
        angle, distance = generator.uniform(np.deg2rad(-70), np.deg2rad(70)), generator.uniform(0.18, 0.38)
        offset = distance * np.array([np.cos(angle), np.sin(angle)])
        bottle_at = cup_at + offset
        new = np.linalg.norm(DEMONSTRATED - offset, axis=1).min() > DIFFERENT
        if new and 0.33 < bottle_at[1] < 0.62 and bottle_at[0] < 0.35:
            break
    yaws = generator.uniform([-180.0, -30.0], [180.0, 30.0])
    library = ObjectLibrary.built_in()
    poses = {
        key: RigidTransform.from_components([*place, 0.0], upright_rotation(library[key].up, yaw))
        for key, place, yaw in ((cup, cup_at, yaws[0]), (bottle, bottle_at, yaws[1]))
    }
    return scene_on_table(f"random pouring {seed}", poses)
