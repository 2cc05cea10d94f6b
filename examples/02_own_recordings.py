"""Read recordings from files, look at what was found in them, and learn from them.

Here the built-in demonstrations are written as MMM 2.0 files first, so that the example has files to read; yours can be
MMM 2.0 or legacy MMM (.xml), KIT CSV (.csv) or SBAM's own arrays (.npz), also mixed.
"""

from pathlib import Path

import sbam
from sbam.demonstrations.report import demonstration_report

folder = Path("out/02_own_recordings")

for demonstration in sbam.built_in_demonstrations("pouring")[:3]:
    sbam.write_demonstration(demonstration, folder / f"{demonstration.name}.xml")

demonstrations = sbam.load(folder)
for demonstration in demonstrations:
    found = demonstration_report(demonstration)
    print(f"{found['name']}: {found['duration']:.1f} s, objects {', '.join(found['objects'])}")
    for hold in found["holds"]:
        print(f"  {hold['hand']} hand holds {hold['object']} from {hold['start']:.2f} to {hold['end']:.2f} s")
    for note in found["notes"]:  # what was missing, repaired or assumed
        print(f"  note: {note}")

model = sbam.learn(demonstrations, constraint="cylindrical", name="pour juice")
sbam.save_model(model, folder / "pour_juice.model.json")

# One more demonstration later: the earlier recordings are not needed for it.
model = sbam.load_model(folder / "pour_juice.model.json")
model = sbam.add_demonstration(model, sbam.built_in_demonstrations("pouring")[3])
print(f"the model now knows {len(model.demonstrations)} demonstrations and has {len(model.keypoint_times)} keypoints")
