"""MMM 2.0: what real files hold, and what must not go wrong with damaged ones."""

import json
import re
import time as clock

import defusedxml.ElementTree
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from sbam.demonstrations.demonstration import Label
from sbam.demonstrations.readers import read_demonstration
from sbam.errors import DemonstrationError, FileFormatError, FileVersionError

ASIDE = np.array([0.0, 300.0, 0.0])
"""Where another object moves alongside, mm."""


def test_millimetres_and_angles(write_mmm, mmm_motion, table, motion):
    time, position, angles = motion
    demonstration = read_demonstration(write_mmm(mmm_motion("milk_small", time + 12.5, position, angles), table))
    assert demonstration.name == "recording"
    assert demonstration.objects == ("milk_small", "kitchen_sideboard")
    np.testing.assert_allclose(demonstration.time, time, atol=1e-12)
    T = demonstration.T_world_object["milk_small"]
    np.testing.assert_allclose(T.translation, position / 1000)
    for k in (0, 20, 40):
        roll, pitch, yaw = angles[k]
        expected = (
            Rotation.from_euler("z", yaw).as_matrix()
            @ Rotation.from_euler("y", pitch).as_matrix()
            @ Rotation.from_euler("x", roll).as_matrix()
        )
        np.testing.assert_allclose(T.rotation.as_matrix()[k], expected, atol=1e-12)


def test_table_tracked_once_stands_still(write_mmm, mmm_motion, table, motion):
    demonstration = read_demonstration(write_mmm(mmm_motion("milk_small", *motion), table))
    np.testing.assert_allclose(
        demonstration.T_world_object["kitchen_sideboard"].translation, np.tile([-0.35, -0.2, 0.855], (41, 1))
    )
    assert any("kitchen_sideboard" in note for note in demonstration.notes)


def test_predicted_motions_are_never_used(write_mmm, mmm_motion, table, motion):
    time, position, angles = motion
    path = write_mmm(
        mmm_motion("true_milk_small", time, position, angles),
        mmm_motion("pred_milk_small", time, position + 100, angles),
        mmm_motion("pred_cup_small", time, position + 100, angles),
        table,
    )
    demonstration = read_demonstration(path)
    assert demonstration.objects == ("milk_small", "kitchen_sideboard")
    np.testing.assert_allclose(demonstration.T_world_object["milk_small"].translation, position / 1000)
    assert "pred_milk_small, pred_cup_small" in demonstration.notes[0]


def test_only_predicted_motions_are_refused(write_mmm, mmm_motion, motion):
    with pytest.raises(FileFormatError, match=r"no object motion with poses .*'pred_milk_small'"):
        read_demonstration(write_mmm(mmm_motion("pred_milk_small", *motion)))


def test_motion_without_poses_is_noted(write_mmm, mmm_motion, motion):
    path = write_mmm(mmm_motion("milk_small", *motion), '<Motion name="knife" type="object"><Sensors/></Motion>')
    demonstration = read_demonstration(path)
    assert demonstration.objects == ("milk_small",)
    assert any("knife" in note for note in demonstration.notes)


@pytest.mark.parametrize(
    ("name", "kind", "head"),
    [
        ("1480", "object", ""),
        ("someone", "object", '<ModelProcessorConfig type="Winter"><Height>1.79</Height></ModelProcessorConfig>'),
        ("someone", "mmm", ""),
    ],
)
def test_the_person_is_no_object_and_gives_the_agent(write_mmm, mmm_motion, table, motion, name, kind, head):
    time, position, angles = motion
    person = mmm_motion(
        name, time, np.tile([200, -100, 930], (41, 1)), np.tile([0, 0, 1.6], (41, 1)), kind=kind, head=head
    )
    demonstration = read_demonstration(write_mmm(person, mmm_motion("milk_small", time, position, angles), table))
    assert demonstration.objects == ("milk_small", "kitchen_sideboard")
    agent = demonstration.T_world_agent
    np.testing.assert_allclose(agent.rotation.as_matrix(), [[0, -1, 0], [1, 0, 0], [0, 0, 1]], atol=1e-12)
    np.testing.assert_allclose(agent.translation[:2], [0.2, -0.1])
    assert 0.86 < agent.translation[2] < 0.89


def test_missing_poses_are_interpolated_and_reported(write_mmm, mmm_motion, motion):
    time, position, angles = motion
    positions = [None if k in (20, 21) else p for k, p in enumerate(position)]
    demonstration = read_demonstration(write_mmm(mmm_motion("milk_small", time, positions, angles)))
    np.testing.assert_allclose(
        demonstration.T_world_object["milk_small"].translation[20],
        (2 * position[19] + position[22]) / 3000,
    )
    assert any("frames 20 to 21 (2.00 to 2.10 s) of milk_small are missing" in note for note in demonstration.notes)


@pytest.mark.parametrize("values", ["nan nan nan", "1 inf 2", ""])
def test_nan_is_a_missing_pose(write_mmm, mmm_motion, motion, values):
    time, position, angles = motion
    text = mmm_motion("milk_small", time, position, angles)
    frame = " ".join(str(v) for v in position[20])
    demonstration = read_demonstration(write_mmm(text.replace(frame, values)))
    assert np.isfinite(demonstration.T_world_object["milk_small"].as_matrix()).all()
    assert any("frame 20 (2.00 to 2.00 s) of milk_small is missing" in note for note in demonstration.notes)


def test_long_loss_is_refused(write_mmm, mmm_motion, motion):
    time, position, angles = motion
    positions = [None if 15 <= k < 25 else p for k, p in enumerate(position)]
    with pytest.raises(DemonstrationError, match=r"milk_small are missing; 1.10 s .* too long to interpolate"):
        read_demonstration(write_mmm(mmm_motion("milk_small", time, positions, angles)))


def test_measurements_left_out_are_interpolated_or_refused(write_mmm, mmm_motion, motion, table):
    def without(frames):
        keep = np.isin(np.arange(41), frames, invert=True)
        return write_mmm(mmm_motion("milk_small", *(values[keep] for values in motion)), table)

    demonstration = read_demonstration(without([20, 21]))
    assert any("milk_small between 1.90 and 2.20 s are missing; interpolated" in note for note in demonstration.notes)
    with pytest.raises(DemonstrationError, match=r"1\.10 s is too long"):
        read_demonstration(without(range(15, 25)))


def test_different_time_stamps_are_brought_to_the_densest(write_mmm, mmm_motion, motion):
    time, position, angles = motion
    uneven = np.sort(np.concatenate([time, time[:-1] + 0.037]))
    dense = np.stack([np.interp(uneven, time, axis) for axis in position.T], axis=-1) + ASIDE
    path = write_mmm(
        mmm_motion("milk_small", time, position, angles),
        mmm_motion("cup_small", uneven, dense, np.tile(angles[0], (81, 1))),
    )
    demonstration = read_demonstration(path)
    np.testing.assert_allclose(demonstration.time, uneven, atol=1e-12)
    T = demonstration.T_world_object["milk_small"]
    np.testing.assert_allclose(T.translation, (dense - ASIDE) / 1000, atol=1e-12)
    between = Rotation.from_euler("xyz", angles[10:12])
    expected = between[0] * Rotation.from_rotvec(0.37 * (between[0].inv() * between[1]).as_rotvec())
    assert (T.rotation[21] * expected.inv()).magnitude() < 1e-9
    assert any("brought to the time stamps of cup_small: milk_small" in note for note in demonstration.notes)


def test_unequal_lengths_are_cut_to_what_is_common(write_mmm, mmm_motion, motion):
    time, position, angles = motion
    short = mmm_motion("cup_small", time[3:-2], position[3:-2] + ASIDE, angles[3:-2])
    demonstration = read_demonstration(write_mmm(mmm_motion("milk_small", *motion), short))
    np.testing.assert_allclose(demonstration.time, time[3:-2] - time[3], atol=1e-12)
    np.testing.assert_allclose(demonstration.T_world_object["milk_small"].translation, position[3:-2] / 1000)
    assert any("cut to 0.30 to 3.80 s" in note for note in demonstration.notes)
    far_too_short = mmm_motion("cup_small", time[20:], position[20:] + ASIDE, angles[20:])
    with pytest.raises(DemonstrationError, match=r"cup_small was tracked from 2\.00 to 4\.00 s only"):
        read_demonstration(write_mmm(mmm_motion("milk_small", *motion), far_too_short))


def test_annotations_become_labels_on_the_time_of_the_demonstration(write_mmm, mmm_motion, motion):
    time, position, angles = motion
    segments = (
        '<Segment><Segmentation><Segment start="5" end="6"><Annotation main="cup" target="">Hold</Annotation></Segment>'
        '</Segmentation><Segmentation><Segment start="5.5" end="7"><Annotation main="milk" target="cup">Pour'
        "</Annotation></Segment></Segmentation></Segment>"
    )
    demonstration = read_demonstration(write_mmm(mmm_motion("milk_small", time + 5, position, angles), segments))
    assert demonstration.labels == (Label("left", 0, 1, "Hold", "cup"), Label("right", 0.5, 2, "Pour", "cup"))


def test_labels_beside_the_file(write_mmm, mmm_motion, motion, tmp_path):
    time, _, _ = motion
    path = write_mmm(mmm_motion("milk_small", *motion))
    labels = {
        "frames_s": list(time),
        "lhand_ids": [0] * 41,
        "rhand_ids": [0] * 20 + [5] * 21,
        "id_names": {"0": "Idle", "5": "Pour"},
    }
    (tmp_path / "recording.json").write_text(json.dumps(labels))
    assert read_demonstration(path).labels == (
        Label("left", 0, 4, "Idle"),
        Label("right", 0, 2, "Idle"),
        Label("right", 2, 4, "Pour"),
    )
    (tmp_path / "recording.json").write_text(json.dumps(labels | {"lhand_ids": [0]}))
    damaged = read_demonstration(path)
    assert damaged.labels == ()
    assert any("recording.json could not be read" in note for note in damaged.notes)


def test_unknown_objects_keep_their_poses(write_mmm, mmm_motion, motion):
    assert read_demonstration(write_mmm(mmm_motion("teapot", *motion))).objects == ("teapot",)


@pytest.mark.parametrize(
    ("damage", "error", "message"),
    [
        (lambda text: "", FileFormatError, "is empty"),
        (lambda text: text[: len(text) // 2], FileFormatError, r"line \d+, column \d+: not well-formed XML"),
        (lambda text: "this is not XML", FileFormatError, "line 1, column 0: not well-formed XML"),
        (lambda text: "<html/>", FileFormatError, "<html>: not an MMM file"),
        (lambda text: re.sub("<Motion .*</Motion>", "", text), FileFormatError, "no object motion .*motions: none"),
        (lambda text: text.replace('timestep="0.5"', 'timestep="0.4"'), FileFormatError, "frame 5: time stamp 0.4 s"),
        (lambda text: text.replace('timestep="0.5"', 'timestep="a"'), FileFormatError, "time stamp is not a number"),
        (lambda text: text.replace('timestep="0.5"', 'timestep="nan"'), FileFormatError, "frame 5: time stamp is not"),
        (lambda text: text.replace('timestep="0.5"', ""), FileFormatError, "time stamp is not a number"),
        (lambda text: text.replace("<RootPosition>", "<RootPosition>1 "), FileFormatError, "RootPosition, frame 0"),
        (lambda text: text.replace("<RootPosition>-", "<RootPosition>x"), FileFormatError, "expected three numbers"),
        (lambda text: text.replace("<RootRotation>1", "<RootRotation>91"), FileFormatError, "implausible.*radians"),
        (lambda text: text.replace('name="milk_small"', ""), FileFormatError, "no name"),
        (
            lambda text: text.replace("<MMM", '<!DOCTYPE m [<!ENTITY a "b"><!ENTITY c "&a;&a;">]><MMM'),
            FileFormatError,
            "declares XML entities",
        ),
    ],
)
def test_bad_files(write_mmm, mmm_motion, motion, damage, error, message):
    path = write_mmm(mmm_motion("milk_small", *motion))
    path.write_text(damage(path.read_text()))
    with pytest.raises(error, match=message) as raised:
        read_demonstration(path)
    assert str(path) in str(raised.value)


def test_one_frame_only(write_mmm, mmm_motion, table, motion):
    time, position, angles = motion
    with pytest.raises(DemonstrationError, match="one frame only"):
        read_demonstration(write_mmm(mmm_motion("milk_small", time[:1], position[:1], angles[:1]), table))


def test_the_same_object_twice(write_mmm, mmm_motion, motion):
    with pytest.raises(FileFormatError, match=r"'milk_small'.* twice"):
        read_demonstration(write_mmm(mmm_motion("milk_small", *motion), mmm_motion("true_milk_small", *motion)))


@pytest.mark.parametrize(("factor", "message"), [(1e-3, "are these metres"), (1e3, "m apart")])
def test_wrong_unit_of_length(write_mmm, mmm_motion, motion, factor, message):
    time, position, angles = motion
    path = write_mmm(
        mmm_motion("milk_small", time, position * factor, angles),
        mmm_motion("cup_small", time, (position + ASIDE) * factor, angles),
    )
    with pytest.raises(FileFormatError, match=message):
        read_demonstration(path)


def test_wrong_unit_of_time(write_mmm, mmm_motion, motion):
    time, position, angles = motion
    with pytest.raises(DemonstrationError, match="one pose every 100 s only"):
        read_demonstration(write_mmm(mmm_motion("milk_small", time * 1000, position, angles)))


def test_file_of_a_later_version(write_mmm, mmm_motion, motion):
    with pytest.raises(FileVersionError, match="version 99"):
        read_demonstration(write_mmm(mmm_motion("milk_small", *motion), '<SBAM format_version="99"/>'))


def test_a_minute_at_100_hz_takes_little_longer_than_parsing_it(write_mmm, mmm_motion, table):
    time = np.arange(6000) / 100
    path = np.stack([200 * np.sin(time), 200 * np.cos(time), 900 + 50 * np.sin(3 * time)], axis=-1).round(3)
    angles = np.stack([1.5 + 0.3 * np.sin(time)] * 3, axis=-1).round(6)
    person = mmm_motion("1480", time, path, 0 * path + [0, 0, 1.6], sensors=person_markers(time, path))
    file = write_mmm(*(mmm_motion(n, time, path, angles) for n in ("milk_small", "cup_small")), person, table)

    def seconds(read) -> float:
        start = clock.process_time()
        read(file)
        return clock.process_time() - start

    assert set(read_demonstration(file).T_world_hand) == {"left", "right"}
    assert min(seconds(read_demonstration) for _ in range(2)) < 4.0 * seconds(defusedxml.ElementTree.parse)


def person_markers(time, path) -> str:
    offsets = {
        f"{side}{name}": np.array([sign * x, y, 0.0])
        for side, sign in (("L", 1), ("R", -1))
        for name, x, y in (("HPS", -40, 0), ("HTS", 40, 0), ("WPS", -30, -70), ("WTS", 30, -70), ("FRA", 0, -150))
    }
    frames = "".join(
        f'<Measurement timestep="{t}">'
        + "".join(
            f'<MarkerPosition name="{n}">{" ".join(map(str, (p + o).round(3)))}</MarkerPosition>'
            for n, o in offsets.items()
        )
        + "</Measurement>"
        for t, p in zip(time, path, strict=True)
    )
    return f'<Sensor type="MoCapMarker" version="1.0"><Data>{frames}</Data></Sensor>'


def test_hands_from_the_markers_of_the_person(write_mmm, mmm_motion, motion):
    time, position, angles = motion
    markers = person_markers(time, position).replace(
        f'<MarkerPosition name="LHPS">{" ".join(map(str, (position[20] + [-40, 0, 0]).round(3)))}</MarkerPosition>', ""
    )
    person = mmm_motion("1480", time, position, 0 * angles, sensors=markers)
    demonstration = read_demonstration(write_mmm(mmm_motion("milk_small", *motion), person))
    assert set(demonstration.T_world_hand) == {"left", "right"}
    # The straight line between the neighbours of the frame without the marker leaves the path by a millimetre.
    np.testing.assert_allclose(demonstration.T_world_hand["left"].translation, position / 1000, atol=2e-3)
    np.testing.assert_allclose(demonstration.T_world_hand["right"].translation, position / 1000, atol=1e-6)
    assert any("frame 20 (2.00 to 2.00 s) of left hand is missing" in note for note in demonstration.notes)


def test_a_hand_that_was_lost_for_long_is_left_out(write_mmm, mmm_motion, motion):
    time, position, angles = motion
    markers = person_markers(time, position)
    for k in range(15, 30):
        markers = markers.replace(
            f'"LHPS">{" ".join(map(str, (position[k] + [-40, 0, 0]).round(3)))}<', '"LHPS">0 0 0<'
        )
    person = mmm_motion("1480", time, position, 0 * angles, sensors=markers)
    demonstration = read_demonstration(write_mmm(mmm_motion("milk_small", *motion), person))
    assert set(demonstration.T_world_hand) == {"right"}
    assert any(note.startswith("left hand left out") for note in demonstration.notes)
