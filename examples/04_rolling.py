"""Two hands on one object: roll out dough with five strokes, the chain of both arms and the pin always closed."""

import sbam

model = sbam.learn(sbam.load("built-in:rolling"), name="roll out")
plan = sbam.plan(model, sbam.load_scene("built-in:rolling"))
if not plan.ok:
    raise SystemExit("\n".join(plan.problems))

for phase in plan.phases:
    print(f"{phase.start:6.2f} to {phase.end:6.2f} s: {phase.hand} hand: {phase.name}")
for check in plan.checks:
    if "keeps its" in check.name:  # how far a hand slips on the pin, over the whole motion
        print(f"{check.name}: at most {check.worst:.2g} {check.unit}")
sbam.write_plan(plan, "out/04_rolling")
