"""Random starting scenes, other than any demonstrated one, before a robot at its default place.

They are the same for every robot, so that robots can be compared; not each of them reaches everything
(`sbam.planning.placement.search.reach_where_it_stands` says by how much).
"""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import RigidTransform, Rotation

from sbam.scene import ObjectLibrary, Scene, upright_rotation

# Layouts of the demonstrations: bottle relative to cup, (right, forward) m.
DEMONSTRATED = np.array([[0.20, 0.0], [0.40 * np.cos(np.pi / 4), 0.40 * np.sin(np.pi / 4)], [-0.30, 0.0]])
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
    places = {cup: (*cup_at, yaws[0]), bottle: (*bottle_at, yaws[1])}
    return _scene(f"random pouring {seed}", places)


def random_rolling_scene(seed: int) -> Scene:
    """A rolling pin lying across, 52-58 cm before the agent, up to 10 cm aside and turned by up to 10 degrees."""
    generator = np.random.default_rng([seed, 2])
    right, forward, yaw, roll = generator.uniform([-0.10, 0.52, -10.0, -30.0], [0.10, 0.58, 10.0, 30.0])
    library = ObjectLibrary.built_in()
    rotation = Rotation.from_euler("z", yaw, degrees=True) * Rotation.from_euler("x", roll, degrees=True)
    pose = RigidTransform.from_components([right, forward, 0.033], rotation)
    table_name, table_pose = _table(library)
    return Scene(
        name=f"random rolling {seed}",
        objects={table_name: library[table_name], "rolling_pin": library["rolling_pin"]},
        T_world_object={table_name: table_pose, "rolling_pin": pose},
        T_world_agent=RigidTransform.identity(),
    )


def _table(library: ObjectLibrary) -> tuple[str, RigidTransform]:
    """A table whose top is at z = 0, long side across, front edge 22 cm before the agent."""
    name = "kitchen_sideboard"
    table = library[name]
    rotation = upright_rotation(table.up, 0.0)
    top = table.region("place onto").center
    return name, RigidTransform.from_components(np.array([0.0, 0.545, 0.0]) - rotation.apply(top), rotation)


def _scene(name: str, places: dict[str, tuple[float, float, float]]) -> Scene:
    library = ObjectLibrary.built_in()
    table_name, table_pose = _table(library)
    objects, poses = {table_name: library[table_name]}, {table_name: table_pose}
    for key, (right, forward, yaw_deg) in places.items():
        objects[key] = library[key]
        rotation = upright_rotation(library[key].up, yaw_deg)
        poses[key] = RigidTransform.from_components([right, forward, 0.0], rotation)
    return Scene(name, objects, poses, RigidTransform.identity())
