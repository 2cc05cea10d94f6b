"""Learn pouring from the built-in demonstrations and plan it for two Pandas in a scene that none of them shows."""

from pathlib import Path

import sbam

folder = Path("out/01_learn_and_plan")

demonstrations = sbam.load("built-in:pouring")  # twelve, synthetic: juice into a large cup, milk into a small one
model = sbam.learn(demonstrations, constraint="cartesian")
scene = sbam.load_scene("built-in:pouring_new_layout")

plan = sbam.plan(model, scene, robot="panda_dual")
for check in plan.checks:
    print(f"{'ok ' if check.ok else 'NOT'} {check.name}: {check.worst:.3g} {check.unit} {check.where}")
if not plan.ok:
    raise SystemExit("\n".join(plan.problems))

for file in sbam.write_plan(plan, folder):
    print(f"wrote {file}")
sbam.view(plan, folder / "recording.html")
print(f"look at {folder / 'recording.html'} in a browser")
