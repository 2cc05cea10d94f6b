"""Learn with juice and a large cup, execute with milk and a small cup: roles bind by affordance, not by name."""

import sbam

juice = [one for one in sbam.built_in_demonstrations("pouring") if "apple_juice" in one.objects]
model = sbam.learn(juice)
for role in model.roles:
    print(f"{role.name}: needs {', '.join(role.affordances)}; was played by {', '.join(role.demonstrated)}")

scene = sbam.load_scene("built-in:pouring_milk")
plan = sbam.plan(model, scene)
for role, name in plan.task.binding.items():
    print(f"{name} plays {role}")
if not plan.ok:
    raise SystemExit("\n".join(plan.problems))

# Where several objects could play a role, say which: sbam.plan(model, scene, roles={"pour_from": "milk_small"})
sbam.write_plan(plan, "out/03_other_objects")
