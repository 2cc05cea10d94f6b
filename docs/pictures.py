"""Make the pictures of the documentation: plan the built-in scenes and draw them into `docs/images/`."""

from pathlib import Path

import sbam
from sbam.viewer.pictures import render_plan

IMAGES = Path(__file__).parent / "images"

for task, scene in (("pouring", "built-in:pouring_new_layout"), ("rolling", "built-in:rolling")):
    plan = sbam.plan(sbam.learn(sbam.load(f"built-in:{task}"), name=task), sbam.load_scene(scene))
    if plan.problems:
        raise SystemExit("\n".join(plan.problems))
    render_plan(plan, IMAGES / f"{task}.png", size=(400, 330))
    print(f"wrote {IMAGES / f'{task}.png'}")
