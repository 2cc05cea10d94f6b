"""Robots: description files, batched kinematics and Jacobians."""

from sbam.robots.description import RobotDescription, read_description
from sbam.robots.jacobian import point_jacobian, rotation_jacobian
from sbam.robots.registry import ROBOTS, load_robot
from sbam.robots.robot import Arm, Kinematics, Robot

__all__ = [
    "ROBOTS",
    "Arm",
    "Kinematics",
    "Robot",
    "RobotDescription",
    "load_robot",
    "point_jacobian",
    "read_description",
    "rotation_jacobian",
]
