"""The registry of formats: by content, then by suffix; files and folders; the real recordings."""

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

from sbam.demonstrations.readers import read_demonstration, read_demonstrations
from sbam.errors import DemonstrationError, FileFormatError


def test_content_goes_before_suffix(write_csv, tmp_path):
    misnamed = tmp_path / "recording.txt"
    write_csv().rename(misnamed)
    assert read_demonstration(misnamed).objects == ("milk_small",)


def test_unknown_format_lists_the_known_ones(tmp_path):
    path = tmp_path / "recording.bvh"
    path.write_text("HIERARCHY")
    with pytest.raises(FileFormatError, match=r"MMM 2.0 \(\*.xml\), .* SBAM NPZ \(\*.npz\)"):
        read_demonstration(path)


def test_missing_file(tmp_path):
    with pytest.raises(FileFormatError, match="No such file"):
        read_demonstration(tmp_path / "none.xml")


def test_folders_and_files(write_csv, write_mmm, mmm_motion, motion, tmp_path):
    write_mmm(mmm_motion("milk_small", *motion), name="a")
    csv = write_csv()
    (tmp_path / "readme.md").write_text("no recording")
    assert [d.name for d in read_demonstrations(tmp_path)] == ["a", "recording"]
    assert [d.name for d in read_demonstrations([csv])] == ["recording"]
    with pytest.raises(DemonstrationError, match=r"'recording'.* is in both"):
        read_demonstrations([tmp_path, csv])


def test_folder_without_recordings(tmp_path):
    with pytest.raises(FileFormatError, match="folder without recordings"):
        read_demonstrations(tmp_path)


def test_the_agent_can_be_given(write_csv):
    agent = RigidTransform.from_translation([1.0, 2.0, 3.0])
    demonstration = read_demonstration(write_csv(), T_world_agent=agent)
    np.testing.assert_allclose(demonstration.T_world_agent.as_matrix(), agent.as_matrix())
    assert not any("agent" in note for note in demonstration.notes)


KIT = {
    "Pour": ("cup_small", "milk_small"),
    "RollOut": ("rolling_pin",),
    "Stir": ("cup_large", "tablespoon"),
    "Close": ("apple_juice", "apple_juice_lid"),
}


@pytest.mark.parametrize("action", KIT)
def test_kit_recordings(recordings_folder, action):
    (path,) = (recordings_folder / "kit_bimanual").glob(f"{action}_*.xml")
    demonstration = read_demonstration(path)
    assert demonstration.objects == (*KIT[action], "kitchen_sideboard")
    assert set(demonstration.T_world_hand) == {"left", "right"}
    np.testing.assert_allclose(np.diff(demonstration.time), 0.1, atol=1e-9)
    assert {label.hand for label in demonstration.labels} == {"left", "right"}
    assert action in {label.action for label in demonstration.labels}
    # The person looks along world -x; what is worked with lies within reach ahead.
    T_agent_world = demonstration.T_world_agent.inv()
    np.testing.assert_allclose(T_agent_world.rotation.as_matrix()[1], [-1, 0, 0], atol=1e-9)
    for name in KIT[action]:
        start = (T_agent_world * demonstration.T_world_object[name])[0].translation
        assert 0.2 < start[1] < 0.7 and abs(start[0]) < 0.4 and -0.01 < start[2] < 0.15
    left, right = (
        T_agent_world.apply(demonstration.T_world_hand[h].translation).mean(axis=0) for h in ("left", "right")
    )
    assert left[0] < 0 < right[0]


def test_objects_do_not_move_in_the_hands_that_hold_them(recordings_folder):
    (path,) = (recordings_folder / "kit_bimanual").glob("Pour_*.xml")
    demonstration = read_demonstration(path)
    for hand, name in (("left", "cup_small"), ("right", "milk_small")):
        # From when the fingers have closed to the end of the pour.
        held = (demonstration.time > 2.5) & (demonstration.time < 4.2)
        T_object_hand = demonstration.T_world_object[name].inv() * demonstration.T_world_hand[hand]
        position = T_object_hand.translation[held]
        rotation = Rotation.from_quat(T_object_hand.rotation.as_quat()[held])
        assert np.ptp(position, axis=0).max() < 0.012
        assert np.linalg.norm(position.mean(axis=0)) < 0.15
        assert np.degrees((rotation * rotation.mean().inv()).magnitude().max()) < 6


def test_file_before_cleaning_gives_the_same_as_the_clean_one(recordings_folder):
    folder = recordings_folder / "kit_bimanual"
    raw, (clean,) = read_demonstration(folder / "raw_Pour_2967_04.xml"), read_demonstrations(folder.glob("Pour_*.xml"))
    assert raw.objects == clean.objects
    for name in raw.objects:
        np.testing.assert_allclose(raw.T_world_object[name].as_matrix(), clean.T_world_object[name].as_matrix())
    np.testing.assert_allclose(raw.T_world_agent.as_matrix(), clean.T_world_agent.as_matrix())
    assert any("pred_milk_small" in note for note in raw.notes)


def test_mmlfd_recordings(recordings_folder):
    demonstrations = read_demonstrations(recordings_folder / "mmlfd_pouring")
    assert len(demonstrations) == 5
    for demonstration in demonstrations:
        assert demonstration.objects == ("bottle", "mug", "table")
        T_agent_world = demonstration.T_world_agent.inv()
        bottle, mug = ((T_agent_world * demonstration.T_world_object[n])[0].translation for n in ("bottle", "mug"))
        # The bottle starts to the right of the mug, both at a comfortable distance.
        assert bottle[0] > 0.2 > -0.2 > mug[0]
        assert abs(bottle[1] - 0.45) < 0.05 and abs(mug[1] - 0.45) < 0.05 and abs(mug[2]) < 1e-9
        assert all("damaged" not in note and "missing" not in note for note in demonstration.notes)
