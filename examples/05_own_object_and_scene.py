"""An object and a scene of your own: two YAML files, `objects/tea_box.yaml` and `breakfast.yaml`."""

from pathlib import Path

import sbam

here = Path(__file__).parent

library = sbam.ObjectLibrary.built_in().with_folder(here / "objects")
scene = sbam.load_scene(here / "breakfast.yaml", library)

model = sbam.learn(sbam.load("built-in:pouring"), constraint="symbolic", library=library)
plan = sbam.plan(model, scene, settings=sbam.PlanSettings(speed=0.3))
if not plan.ok:
    raise SystemExit("\n".join(plan.problems))
print(f"{plan.task.binding['pour_from']} is poured into {plan.task.binding['pour_into']}")
print(f"{plan.trajectory.duration:.1f} s at 30 % of the robot's speed")
sbam.write_plan(plan, "out/05_own_object_and_scene")
