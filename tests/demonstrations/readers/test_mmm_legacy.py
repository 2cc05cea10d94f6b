"""Legacy MMM 1: motion frames instead of sensors."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from sbam.demonstrations.readers import read_demonstration
from sbam.errors import FileFormatError


def legacy_motion(name, time, position, angles, head="", joints="") -> str:
    frames = "".join(
        f"<MotionFrame><Timestep>{t}</Timestep><RootPosition>{x} {y} {z}</RootPosition>"
        f"<RootRotation>{r} {p} {w}</RootRotation>{joints}</MotionFrame>"
        for t, (x, y, z), (r, p, w) in zip(time, position, angles, strict=True)
    )
    return (
        f"<Motion name='{name}'><Model><File>no/such/file.xml</File></Model>{head}"
        f"<MotionFrames>{frames}</MotionFrames></Motion>"
    )


def test_reads_objects_and_the_person(tmp_path, motion):
    time, position, angles = motion
    joints = "<JointOrder><Joint name='LEx_joint'/></JointOrder>"
    person = legacy_motion(
        "subject",
        time,
        position * 0 + [200, -100, 930],
        angles * 0 + [0, 0, 1.6],
        joints,
        "<JointPosition>0.3</JointPosition>",
    )
    path = tmp_path / "old.xml"
    path.write_text(f"<MMM>{legacy_motion('milk_small', time, position, angles)}{person}</MMM>")
    demonstration = read_demonstration(path)
    assert demonstration.objects == ("milk_small",)
    T = demonstration.T_world_object["milk_small"]
    np.testing.assert_allclose(T.translation, position / 1000)
    assert (T.rotation * Rotation.from_euler("xyz", angles).inv()).magnitude().max() < 1e-12
    np.testing.assert_allclose(demonstration.T_world_agent.translation[:2], [0.2, -0.1])


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("<Timestep>0.5</Timestep>", "<Timestep>0.1</Timestep>", "frame 5: time stamp 0.1 s does not come after 0.4"),
        ("<Timestep>0.5</Timestep>", "", "time stamp is not a number"),
        ("milk_small", "pred_milk_small", "no object motion"),
        ("<RootRotation>", "<RootRotation>7 ", "three numbers"),
    ],
)
def test_bad_files(tmp_path, motion, old, new, message):
    path = tmp_path / "old.xml"
    path.write_text(f"<MMM>{legacy_motion('milk_small', *motion)}</MMM>".replace(old, new))
    with pytest.raises(FileFormatError, match=message):
        read_demonstration(path)
