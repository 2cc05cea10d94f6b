"""Clearances of the Panda agree with Coal, which poses and measures the same primitives on its own."""

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

from sbam.robots import CollisionModel, load_robot
from sbam.scene import ObjectLibrary

coal = pytest.importorskip("coal")
DISTANCE_MAX = 0.15


def coal_shapes(object_model, pose):
    for primitive in object_model.geometry:
        at = pose * primitive.T_object_primitive
        place = coal.Transform3s(at.rotation.as_matrix(), at.translation)
        size = primitive.size
        shape = coal.Box(*(2 * size)) if primitive.kind == "box" else coal.Cylinder(size[0], 2 * size[1])
        yield shape, place


def distance(shapes, others):
    best = np.inf
    for shape, place in shapes:
        for other, there in others:
            request, result = coal.DistanceRequest(), coal.DistanceResult()
            request.enable_signed_distance = True
            best = min(best, coal.distance(shape, place, other, there, request, result))
    return best


def test_palms_and_objects_at_random_poses():
    """Palm boxes against each other and against a cup and a bottle that are anywhere near."""
    robot = load_robot("panda_dual")
    library = ObjectLibrary.built_in()
    objects = {name: library[name] for name in ("cup_large", "apple_juice")}
    links = [name for name in robot.frame_names if "link" in name or "finger" in name]
    collisions = CollisionModel(
        robot, objects, allowed=[(link, name) for link in links for name in (*objects, "left_hand", "right_hand")]
    )
    generator = np.random.default_rng(5)
    q = robot.clip(robot.home + generator.normal(size=(150, 14)) * 0.4)
    palms = robot.kinematics(q, ["left_hand", "right_hand"])
    poses = {
        name: RigidTransform.from_components(
            palms.position[:, hand] + generator.normal(size=(150, 3)) * 0.12, Rotation.random(150, rng=generator)
        )
        for hand, name in enumerate(objects)
    }
    held = {(name, "left"): np.zeros(150, dtype=bool) for name in objects}
    held["cup_large", "left"][:] = True
    report = collisions.clearances(q, poses, held, distance_max=DISTANCE_MAX)
    near = 0
    for sample in range(150):
        boxes = []
        for hand in range(2):
            center = palms.position[sample, hand] + palms.rotation[sample, hand] @ [0, 0, 0.033]
            place = coal.Transform3s(palms.rotation[sample, hand], center)
            boxes.append([(coal.Box(0.063, 0.204, 0.066), place)])
        shapes = {name: list(coal_shapes(objects[name], poses[name][sample])) for name in objects}
        expected = min(
            distance(boxes[0], shapes["cup_large"]),
            distance(boxes[1], shapes["cup_large"]),
            distance(boxes[0], shapes["apple_juice"]),
            distance(boxes[1], shapes["apple_juice"]),
        )
        found = min(report.distance_by_class[name][sample] for name in ("arm-object", "palm-object"))
        if expected > 0.0:
            assert found == pytest.approx(min(expected, DISTANCE_MAX), abs=5e-6)
        else:  # of depths only the sign is reliable
            assert found < 5e-6
        between = distance(shapes["cup_large"], shapes["apple_juice"])
        assert report.distance_by_class["object-object"][sample] == pytest.approx(min(between, DISTANCE_MAX), abs=5e-6)
        near += found < DISTANCE_MAX
    assert near > 50
