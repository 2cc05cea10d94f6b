"""What is tried in physics: the arms of a plan, or the objects of a demonstration alone."""

from __future__ import annotations

from sbam.demonstrations.demonstration import Demonstration
from sbam.demonstrations.scenes import scene_from_demonstration
from sbam.planning.plan import Plan
from sbam.scene import ObjectLibrary
from sbam.tasks.action import Action, Arms, Grip


def action_of_plan(plan: Plan) -> Action:
    """The arms of a plan and what they shall do to the objects."""
    grips = []
    for (role, hand), grasp in plan.grasps.items():
        phases = {phase.name: phase for phase in plan.phases if phase.role == role and phase.hand == hand}
        grips.append(
            Grip(
                hand=hand,
                object=plan.task.binding[role],
                T_object_tcp=grasp.T_object_tcp,
                width=grasp.width,
                start=phases["manipulate"].start,
                end=phases["manipulate"].end,
                closing=phases["grasp"].start,
                opened=phases["place"].end,
            )
        )
    robot = plan.robot
    return Action(
        name=f"{plan.task.model.name} in {plan.task.scene.name} by {plan.robot.name}",
        scene=plan.task.scene,
        roles=dict(plan.task.binding),
        time=plan.trajectory.time,
        T_world_object=plan.object_poses(),
        arms=Arms(robot, plan.trajectory, tuple(grips)),
    )


def action_of_demonstration(demonstration: Demonstration, library: ObjectLibrary | None = None) -> Action:
    """The objects of a demonstration alone, led along their recorded poses.

    Raises:
        UnknownNameError: if the library lacks an object that moves.
    """
    scene = scene_from_demonstration(demonstration, library)
    movable = [name for name, model in scene.objects.items() if model.movable]
    return Action(
        name=demonstration.name,
        scene=scene,
        roles={},
        time=demonstration.time - demonstration.time[0],
        T_world_object={name: demonstration.T_world_object[name] for name in movable},
    )
