"""Robots: description files, batched kinematics, Jacobians, collision checks, human-likeness."""

from sbam.robots.collision import ClearanceReport, CollisionModel, NearPairs, ObjectHand
from sbam.robots.collision_pairs import PAIR_CLASSES
from sbam.robots.description import RobotDescription, read_description
from sbam.robots.human_likeness import NaturalDirections
from sbam.robots.jacobian import point_jacobian, rotation_jacobian
from sbam.robots.registry import ROBOTS, load_robot
from sbam.robots.robot import Arm, Kinematics, Robot

__all__ = [
    "PAIR_CLASSES",
    "ROBOTS",
    "Arm",
    "ClearanceReport",
    "CollisionModel",
    "Kinematics",
    "NaturalDirections",
    "NearPairs",
    "ObjectHand",
    "Robot",
    "RobotDescription",
    "load_robot",
    "point_jacobian",
    "read_description",
    "rotation_jacobian",
]
