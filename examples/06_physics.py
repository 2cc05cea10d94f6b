"""Try plans and demonstrations in physics: what do they do to the dough?"""

import json
from pathlib import Path

import sbam
from sbam.errors import RenderingError
from sbam.simulation.film import write_film
from sbam.simulation.report import simulation_report

folder = Path("out/physics")
folder.mkdir(parents=True, exist_ok=True)

demonstrations = sbam.load("built-in:rolling")
model = sbam.learn(demonstrations)
plan = sbam.plan(model, sbam.load_scene("built-in:rolling"))

result = sbam.simulate(plan, demonstrations=demonstrations[:1])
print("success" if result.ok else f"failure: {result.problems}", f"at {result.speed:.1f} x real time")
for name, value in result.values.items():
    if isinstance(value, float):
        print(f"{name:45s} {value:8.2f}   demonstrated {result.yardstick[name]:8.2f}")
(folder / "physics.json").write_text(json.dumps(simulation_report(result)))
try:
    write_film(result, folder / "rolling.png")  # .mp4 for a film, with PyAV
except RenderingError as error:  # without OpenGL there is no picture, but physics runs
    print(error)
