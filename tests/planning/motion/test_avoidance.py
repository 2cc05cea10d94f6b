"""Keeping clear between the keypoints."""

from dataclasses import replace

import numpy as np
from scipy.spatial.transform import RigidTransform, Rotation

from sbam.planning.motion.allowed_contacts import collision_model
from sbam.planning.motion.avoidance import clearance_term
from sbam.planning.motion.carrying import hold_objects
from sbam.planning.motion.motion import Motion, with_approaches
from sbam.planning.plan import Plan, plan
from sbam.planning.settings import PlanSettings
from sbam.planning.start import in_agent_frame
from sbam.tasks import random_pouring_scene


def carried(plan: Plan, motion: Motion, step: np.ndarray) -> Motion:
    """The motion with every configuration moved by a step, the objects in the hands moved along."""
    q = motion.configurations + step
    objects = {}
    for moved in plan.task.moved:
        frame = plan.robot.arms[moved.hands[0]].tcp_frame
        k = in_agent_frame(plan.robot).kinematics(q, [frame])
        tcp = RigidTransform.from_components(k.position[:, 0], Rotation.from_matrix(k.rotation[:, 0]))
        objects[moved.name] = tcp * plan.grasps[moved.role, moved.hands[0]].T_object_tcp.inv()
    return replace(motion, configurations=q, T_agent_object=objects)


def test_gradients_predict_distances(small_plan, problem_of):
    times, q = small_plan.task.model.keypoint_times, small_plan.solution.configurations
    robot = in_agent_frame(small_plan.robot)
    shapes = collision_model(small_plan.task, robot)
    poses = problem_of(small_plan).state(q).object_poses()
    holding = hold_objects(small_plan.task, robot, small_plan.grasps, times, q, poses)
    motion = with_approaches(small_plan.task, robot, shapes, holding)
    both = [p for p in motion.phases if p.name == "manipulate"]
    within = (motion.clock > max(p.start for p in both)) & (motion.clock < min(p.end for p in both))
    cut = replace(
        motion,
        clock=motion.clock[within],
        model_time=motion.model_time[within],
        configurations=motion.configurations[within],
        T_agent_object={name: poses[within] for name, poses in motion.T_agent_object.items()},
    )
    arguments = (small_plan.task, robot, shapes)
    step = 1e-5 * np.random.default_rng(0).standard_normal(q.shape[1])
    here = clearance_term(*arguments, carried(small_plan, cut, 0.0 * step), times, q, 0.2)
    there = clearance_term(*arguments, carried(small_plan, cut, step), times, q, 0.2)
    # Intervals in which the same pairs are in view.
    same = np.isfinite(here.distance).sum(axis=1) == np.isfinite(there.distance).sum(axis=1)
    width = min(here.distance.shape[1], there.distance.shape[1])
    some = np.isfinite(here.distance[same, :width])
    assert some.sum() > 50
    change = there.distance[same, :width][some] - here.distance[same, :width][some]
    # At edges of boxes the nearest points jump; everywhere else the gradient is exact.
    agrees = np.isclose(change, (here.gradient @ step)[same, :width][some], rtol=1e-2, atol=1e-8)
    assert agrees.mean() > 0.9


def test_the_arms_keep_the_distance_that_is_asked_for(small_plan, monkeypatch):
    more, model, scene = 0.01, small_plan.task.model, random_pouring_scene(4)
    monkeypatch.setattr("sbam.planning.search.ATTEMPTS", 1)  # other grasps would help too
    first = plan(model, scene, "panda_dual")
    least = next(check.worst for check in first.checks if check.name == "clearance arm-arm")
    assert least + more < 0.1  # beyond it distances are not measured
    wanted = PlanSettings(clearance=least + more)
    found = {}
    for avoid in (False, True):
        again = plan(model, scene, "panda_dual", settings=replace(wanted, avoid_collisions=avoid))
        found[avoid] = next(check for check in again.checks if check.name == "clearance arm-arm")
    assert not found[False].ok
    assert found[True].worst >= found[False].worst + 0.8 * more
