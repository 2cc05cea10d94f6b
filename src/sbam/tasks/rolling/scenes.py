"""Random starting scenes of rolling, before a robot at its default place.

They are the same for every robot, so that robots can be compared; not each of them reaches everything
(`sbam.planning.placement.search.reach_where_it_stands` says by how much).
"""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import RigidTransform, Rotation

from sbam.scene import Scene
from sbam.tasks.table_scene import scene_on_table


def random_rolling_scene(seed: int) -> Scene:
    """A rolling pin lying across, 52-58 cm before the agent, up to 10 cm aside and turned by up to 10 degrees."""
    generator = np.random.default_rng([seed, 2])
    right, forward, yaw, roll = generator.uniform([-0.10, 0.52, -10.0, -30.0], [0.10, 0.58, 10.0, 30.0])
    rotation = Rotation.from_euler("z", yaw, degrees=True) * Rotation.from_euler("x", roll, degrees=True)
    pose = RigidTransform.from_components([right, forward, 0.033], rotation)
    return scene_on_table(f"random rolling {seed}", {"rolling_pin": pose})
