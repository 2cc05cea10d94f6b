"""Make the pictures of the documentation: plan the built-in scenes and draw them into `docs/images/`.

The clip shows what physics makes of the pour: from when the bottle begins to tilt until it is upright again.
"""

from pathlib import Path

import sbam
from sbam.simulation.film import write_film
from sbam.viewer.pictures import render_plan

IMAGES = Path(__file__).parent / "images"
BEFORE, AFTER = 2.0, 1.6  # s shown before the first drop and after the last

for task, scene in (("pouring", "built-in:pouring_new_layout"), ("rolling", "built-in:rolling")):
    plan = sbam.plan(sbam.learn(sbam.load(f"built-in:{task}"), name=task), sbam.load_scene(scene))
    if plan.problems:
        raise SystemExit("\n".join(plan.problems))
    render_plan(plan, IMAGES / f"{task}.png", size=(400, 330))
    print(f"wrote {IMAGES / f'{task}.png'}")
    if task == "pouring":
        result = sbam.simulate(plan, task)
        if not result.ok:
            raise SystemExit("\n".join(result.problems))
        first, last = result.values["flow begins [s]"], result.values["flow ends [s]"]
        clip = IMAGES / "pouring.webp"
        write_film(result, clip, between=(first - BEFORE, last + AFTER), size=(480, 360), close=True)
        print(f"wrote {clip}: {clip.stat().st_size / 1e3:.0f} kB")
