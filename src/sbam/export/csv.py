"""``trajectory.csv`` and ``objects.csv``: text with one named column, with its unit, for each number.

``trajectory.csv``: ``time[s]``, then for every joint ``<joint>.position[rad]``, then all ``.velocity[rad/s]``, then all
``.acceleration[rad/s^2]`` (m for prismatic joints). ``objects.csv``: ``time[s]``, then for every moved object
``<object>.x[m]``, ``.y[m]``, ``.z[m]`` in the world and the unit quaternion ``.qw``, ``.qx``, ``.qy``, ``.qz``. Numbers
have ten significant digits.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from jaxtyping import Float

from sbam.export.npz import quaternions_wxyz
from sbam.planning.plan import Plan

TRAJECTORY_FILE = "trajectory.csv"
OBJECTS_FILE = "objects.csv"


def encode(plan: Plan) -> Mapping[str, bytes]:
    """File name -> content."""
    trajectory = plan.trajectory
    columns = ["time[s]"]
    for quantity, per_time in (("position", ""), ("velocity", "/s"), ("acceleration", "/s^2")):
        for name, prismatic in zip(trajectory.joint_names, plan.robot.is_prismatic, strict=True):
            columns.append(f"{name}.{quantity}[{'m' if prismatic else 'rad'}{per_time}]")
    poses = plan.object_poses()
    object_columns = ["time[s]"]
    for name in poses:
        object_columns += [f"{name}.{axis}[m]" for axis in "xyz"] + [f"{name}.q{axis}" for axis in "wxyz"]
    pose_arrays = [array for T in poses.values() for array in (T.translation, quaternions_wxyz(T))]
    return {
        TRAJECTORY_FILE: _table(
            columns, trajectory.time, trajectory.position, trajectory.velocity, trajectory.acceleration
        ),
        OBJECTS_FILE: _table(object_columns, trajectory.time, *pose_arrays),
    }


def _table(columns: Sequence[str], *arrays: Float[np.ndarray, "samples ..."]) -> bytes:
    header = ",".join(_quoted(column) for column in columns)
    row = ",".join(["%.10g"] * len(columns))
    rows = np.column_stack(arrays).tolist()
    return "\n".join([header, *(row % tuple(values) for values in rows), ""]).encode()


def _quoted(text: str) -> str:
    """The text as one field, whatever an object is called."""
    return '"' + text.replace('"', '""') + '"' if set(text) & set(',"\r\n') else text
