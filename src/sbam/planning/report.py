"""Machine-readable report of a plan; its keys are documented in docs/reports.md and do not change within a version."""

from __future__ import annotations

from typing import Any

import numpy as np

from sbam.plain import plain, pose_dict
from sbam.planning.keypoints.terms.human_likeness import human_likeness_weight
from sbam.planning.plan import Plan
from sbam.robots import NaturalDirections
from sbam.robots.human_likeness import PERSON_SWIVEL_DEG
from sbam.robots.natural_joints import NaturalJoints, has_natural_joints

REPORT_VERSION = 1


def plan_report(plan: Plan) -> dict[str, Any]:
    """Everything that is worth knowing of a plan beside the trajectory itself.

    Args:
        plan: a plan, whether it is ok or not.

    Returns:
        Dictionaries, lists, text, numbers, booleans and None only; numbers that are not finite become None. SI units;
        angles whose key ends in ``_deg`` are in degrees.
    """
    scene, model, solution = plan.task.scene, plan.task.model, plan.solution
    report = {
        "report": "plan",
        "report_version": REPORT_VERSION,
        "ok": plan.ok,
        "problems": plan.problems,
        "notes": plan.notes,
        "seconds": {"total": sum(plan.seconds.values()), **plan.seconds},
        "objective": solution.objective,
        "objective_without_robot": plan.free_flight.objective,
        "duration_s": plan.trajectory.duration,
        "samples": len(plan.trajectory.time),
        "joint_names": plan.trajectory.joint_names,
        "checks": [
            {"name": c.name, "ok": c.ok, "worst": c.worst, "limit": c.limit, "unit": c.unit, "where": c.where}
            for c in plan.checks
        ],
        "robot": {
            "name": plan.robot.name,
            "file": plan.robot.description.path,
            "options": plan.robot.description.options,
            "T_world_base": pose_dict(plan.robot.T_world_base),
        },
        "scene": {"name": scene.name, "source": scene.source, "objects": tuple(scene.objects)},
        "model": {
            "name": model.name,
            "constraint": model.constraint,
            "mode": model.mode,
            "demonstrations": len(model.demonstrations),
        },
        "synthetic": model.synthetic,
        "roles": plan.task.binding,
        "grasps": [
            {
                "hand": key.hand,
                "role": key.role,
                "object": plan.task.binding[key.role],
                "region": grasp.region,
                "azimuth_deg": np.degrees(grasp.azimuth),
                "tilt_deg": np.degrees(grasp.tilt),
                "flipped": grasp.flipped,
                "human_distance_deg": np.degrees(grasp.human_distance),
                "T_object_tcp": pose_dict(grasp.T_object_tcp),
            }
            for key, grasp in plan.grasps.items()
        ],
        "phases": [
            {
                "hand": phase.hand,
                "name": phase.name,
                "role": phase.role,
                "object": plan.task.binding.get(phase.role),
                "start_s": phase.start,
                "end_s": phase.end,
            }
            for phase in plan.phases
        ],
        "keypoints": _keypoints(plan),
        "human_likeness": _human_likeness(plan),
        "solver": {
            "name": solution.solver,
            "starts": solution.starts,
            "iterations": solution.iterations,
            "seconds": solution.seconds,
        },
    }
    return plain(report)


def _human_likeness(plan: Plan) -> dict[str, Any]:
    """How natural the arms' postures are at every keypoint, for the weight that was planned with."""
    robot, configurations = plan.robot, plan.solution.configurations
    likeness = NaturalDirections(robot)
    kinematics = robot.kinematics(configurations, likeness.frames)
    deviation, swivel = likeness.deviation(kinematics), likeness.swivel(kinematics)
    joint_form = None
    if has_natural_joints(robot):
        joints = NaturalJoints(robot)
        joint_form = joints.value(robot.kinematics(configurations, joints.frames), configurations)
    return {
        "weight": human_likeness_weight(robot, plan.settings),
        "arms": [
            {
                "arm": arm,
                "upper_arm_deg": deviation[:, index, 0],
                "forearm_deg": deviation[:, index, 1],
                "swivel_deg": swivel[:, index],
                "swivel_of_people_deg": PERSON_SWIVEL_DEG[arm],
                "soa_q": None if joint_form is None else joint_form[:, index],
            }
            for index, arm in enumerate(robot.arms)
        ],
    }


def _keypoints(plan: Plan) -> list[dict[str, Any]]:
    solution, model_times = plan.solution, plan.task.model.keypoint_times
    times = np.interp(model_times, plan.model_time, plan.trajectory.time)
    return [
        {
            "index": index,
            "time_s": times[index],
            "model_time_s": model_times[index],
            "terms": {
                term: {group: cost[index] for group, cost in groups.items()} for term, groups in solution.terms.items()
            },
            "active_limits": solution.active_limits[index],
        }
        for index in range(len(model_times))
    ]
