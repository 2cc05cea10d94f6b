"""Damage is found, mended where short, refused where long; fast clean motion is left alone."""

import re

import defusedxml.ElementTree
import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import RigidTransform, Rotation

from sbam.demonstrations.damage import find_damaged_frames
from sbam.demonstrations.demonstration import Demonstration
from sbam.demonstrations.readers import read_demonstration
from sbam.demonstrations.recording import Track
from sbam.demonstrations.repair import repair_demonstration, repair_track
from sbam.demonstrations.resampling import resample
from sbam.demonstrations.synthetic import built_in_demonstrations
from sbam.errors import DemonstrationError


def carried(rate: float, duration: float = 6.0, yaw: float = 3.0) -> Track:
    """Something that is carried half a metre and turned, from and to rest, and shaken a little all the time."""
    time = np.arange(round(duration * rate) + 1) / rate
    phase = np.clip((time - 2) / 1.5, 0, 1)
    blend = phase**3 * (10 - 15 * phase + 6 * phase**2)
    position = np.stack([0.5 * blend, 0.01 * np.sin(5 * time), 0.9 + 0.3 * blend * (1 - blend)], axis=-1)
    rotation = Rotation.from_euler("zx", np.stack([yaw + 0.02 * np.sin(5 * time), 1.2 * blend], axis=-1))
    return Track(time, position, rotation.as_quat())


def with_(track: Track, position=None, rotation: Rotation | None = None) -> Track:
    return Track(
        track.time,
        track.position if position is None else position,
        track.rotation_xyzw if rotation is None else rotation.as_quat(),
    )


def angle_between(a: Track, b: Track) -> np.ndarray:
    return (Rotation.from_quat(a.rotation_xyzw) * Rotation.from_quat(b.rotation_xyzw).inv()).magnitude()


@pytest.mark.parametrize("rate", [10.0, 30.0, 100.0])
def test_clean_motion_is_returned_as_it_is(rate):
    track = carried(rate)
    mended, notes = repair_track(track, "cup", "d")
    assert notes == ()
    assert mended is track


@pytest.fixture(scope="module")
def built_in() -> list[Demonstration]:
    return [*built_in_demonstrations("pouring")[::4], *built_in_demonstrations("rolling")[::4]]


@pytest.mark.parametrize("rate", [5.0, 10.0, 20.0, 30.0, 60.0, 100.0])
def test_built_in_demonstrations_are_clean(built_in, rate):
    for demonstration in built_in:
        sampled = resample(demonstration, rate)
        assert repair_demonstration(sampled) is sampled


@pytest.mark.parametrize("rate", [10.0, 30.0, 100.0])
@pytest.mark.parametrize("frequency", [1.0, 2.0, 3.0])
def test_shaking_is_no_damage(frequency, rate):
    time = np.arange(round(3 * rate) + 1) / rate
    swing = np.sin(2 * np.pi * frequency * time)
    rotation = Rotation.from_euler("x", np.radians(40) * swing[:, None])
    track = Track(time, np.outer(0.09 * swing, [1.0, 0, 0]), rotation.as_quat())
    assert not find_damaged_frames(track).any()


def test_rolling_freely_is_no_damage():
    """Strokes of 14 cm with a pin of 33 mm radius that does not slide: 243 degrees in half a second."""
    time = np.arange(51) / 10
    stroke = 0.07 * np.cos(2 * np.pi * time)
    track = Track(time, np.outer(stroke, [1.0, 0, 0]), Rotation.from_euler("y", stroke[:, None] / 0.033).as_quat())
    assert not find_damaged_frames(track).any()


@pytest.mark.parametrize(("rate", "frames"), [(10.0, 1), (10.0, 3), (10.0, 5), (100.0, 1), (100.0, 7), (100.0, 50)])
@pytest.mark.parametrize("start_s", [0.7, 2.5])
def test_outliers_are_interpolated(rate, frames, start_s):
    track = carried(rate)
    start = round(start_s * rate)
    position = track.position.copy()
    position[start : start + frames] += [0.3, -0.4, 0.2]
    mended, notes = repair_track(with_(track, position), "cup", "d")
    assert len(notes) == 1
    assert re.match(f"frames? {start} .* of cup (is|are) damaged; interpolated", notes[0])
    keep = np.ones(len(track.time), dtype=bool)
    keep[start : start + frames] = False
    np.testing.assert_array_equal(mended.position[keep], track.position[keep])
    assert np.linalg.norm(mended.position - track.position, axis=1).max() < 0.12
    assert angle_between(mended, track).max() < 0.3


@pytest.mark.parametrize(("rate", "size"), [(10.0, 0.14), (30.0, 0.05), (100.0, 0.04)])
def test_small_single_outliers(rate, size):
    track = carried(rate)
    position = track.position.copy()
    frames = [round(second * rate) for second in (0.7, 1.5, 4.5)]
    position[frames] += [0, size, 0]
    mended, notes = repair_track(with_(track, position), "cup", "d")
    assert len(notes) == 3
    np.testing.assert_allclose(mended.position, track.position, atol=2e-3)


@pytest.mark.parametrize(
    ("rate", "steps"), [(10.0, 2), (10.0, 3), (10.0, 4), (10.0, 5), (10.0, 6), (100.0, 2), (100.0, 10), (100.0, 40)]
)
@pytest.mark.parametrize("rest", [0.0, 0.2])
def test_the_long_way_round_of_interpolated_angles(rate, steps, rest):
    """A yaw that passes pi and was interpolated as a number runs all the way back through zero."""
    track = carried(rate, yaw=3.0)
    angles = Rotation.from_quat(track.rotation_xyzw).as_euler("xyz")
    angles[:, 2] = np.pi - 0.1 + rest * track.time / track.time[-1]
    clean = with_(track, rotation=Rotation.from_euler("xyz", angles))
    first = round(0.5 * rate)
    damaged = angles.copy()
    blend = np.arange(steps + 1) / steps
    end = damaged[first + steps].copy()
    end[2] -= 2 * np.pi
    damaged[first : first + steps + 1] = np.outer(1 - blend, damaged[first]) + np.outer(blend, end)
    mended, notes = repair_track(with_(track, rotation=Rotation.from_euler("xyz", damaged)), "cup", "d")
    assert len(notes) == 1 and "damaged; interpolated" in notes[0]
    assert angle_between(mended, clean).max() < 0.05


@pytest.mark.parametrize("at_end", [False, True])
@pytest.mark.parametrize("frames", [1, 5])
def test_damage_at_the_edge_holds_the_nearest_pose(at_end, frames):
    track = carried(10.0)
    where = slice(-frames, None) if at_end else slice(0, frames)
    rotation = Rotation.from_quat(track.rotation_xyzw).as_matrix()
    rotation[where] = Rotation.from_euler("x", 70, degrees=True).as_matrix() @ rotation[where]
    mended, notes = repair_track(with_(track, rotation=Rotation.from_matrix(rotation)), "spoon", "d")
    assert len(notes) == 1 and "held the nearest sound pose" in notes[0]
    assert np.degrees(angle_between(mended, track).max()) < 2


def test_long_damage_is_refused():
    track = carried(10.0)
    position = track.position.copy()
    position[10:22] += [0, 0, 0.5]
    with pytest.raises(DemonstrationError, match=r"frames 10 to 21 \(1.00 to 2.10 s\) of cup are damaged; 1.30 s"):
        repair_track(with_(track, position), "cup", "d")
    position = track.position.copy()
    position[30:] += [0, 0, 0.5]
    with pytest.raises(DemonstrationError, match=r"frames 0 to 29 .*damaged"):
        repair_track(with_(track, position), "cup", "d")


def test_nothing_but_noise_is_refused():
    rng = np.random.default_rng(0)
    track = carried(100.0)
    with pytest.raises(DemonstrationError):
        repair_track(with_(track, track.position + rng.normal(scale=0.5, size=track.position.shape)), "cup", "d")


@settings(max_examples=40, deadline=None)
@given(start=st.integers(0, 60), frames=st.integers(1, 12), rate=st.sampled_from([10.0, 20.0]), hidden=st.booleans())
def test_gaps_are_mended_up_to_the_limit_and_refused_beyond(start, frames, rate, hidden):
    track = carried(rate)
    stop = min(start + frames, len(track.time) - 1)
    assume(stop > start)
    position = track.position.copy()
    position[start:stop] = np.nan if hidden else position[start:stop] + 1.0
    gap = (stop - max(start - 1, 0)) / rate
    if gap > 0.6 + 1e-9:
        with pytest.raises(DemonstrationError, match="too long to interpolate"):
            repair_track(with_(track, position), "cup", "d")
        return
    mended, notes = repair_track(with_(track, position), "cup", "d")
    assert len(notes) == 1 and ("missing" if hidden else "damaged") in notes[0]
    assert np.isfinite(mended.position).all() and np.isfinite(mended.rotation_xyzw).all()
    np.testing.assert_allclose(np.linalg.norm(mended.rotation_xyzw, axis=1), 1)
    assert np.linalg.norm(mended.position - track.position, axis=1).max() < 0.15


def test_a_demonstration_made_in_python():
    track = carried(10.0)
    position = track.position.copy()
    position[20:22] += 1.0
    demonstration = Demonstration(
        name="made",
        time=track.time,
        T_world_object={"cup": with_(track, position).poses, "table": carried(10.0, yaw=0).poses},
        T_world_hand={"left": track.poses},
        T_world_agent=RigidTransform.identity(),
        notes=("before",),
    )
    mended = repair_demonstration(demonstration)
    assert mended.notes[0] == "before" and len(mended.notes) == 2
    assert mended.T_world_object["table"] is demonstration.T_world_object["table"]
    np.testing.assert_allclose(mended.T_world_object["cup"].translation, track.position, atol=0.02)


def markers_of(path, name) -> np.ndarray:
    """(T, M, 3) mm."""
    root = defusedxml.ElementTree.parse(path).getroot()
    frames = root.findall(f"Motion[@name='{name}']/Sensors/Sensor[@type='MoCapMarker']/Data/Measurement")
    return np.array([[[float(v) for v in marker.text.split()] for marker in frame] for frame in frames])


@pytest.mark.parametrize(("action", "name"), [("Stir", "tablespoon"), ("Close", "apple_juice_lid")])
def test_damaged_kit_frames_agree_with_the_markers_after_repair(recordings_folder, action, name):
    """The first five poses of both are off by more than 60 degrees, while their own markers lie still."""
    (path,) = (recordings_folder / "kit_bimanual").glob(f"{action}_*.xml")
    demonstration = read_demonstration(path)
    damaged = [note for note in demonstration.notes if "damaged" in note]
    assert damaged == [f"frames 0 to 4 (0.00 to 0.40 s) of {name} are damaged; held the nearest sound pose"]
    markers = markers_of(path, name) / 1000
    T = demonstration.T_world_object[name]
    local = np.stack([T.inv().apply(markers[:, k]) for k in range(markers.shape[1])], axis=1)
    off = np.linalg.norm(local[:5] - np.median(local[5:], axis=0), axis=2)
    assert off.max() < 0.002
    before = [
        element.text
        for element in defusedxml.ElementTree.parse(path)
        .getroot()
        .iterfind(f"Motion[@name='{name}']/Sensors/Sensor[@type='ModelPose']/Data/Measurement/RootRotation")
    ]
    recorded = Rotation.from_euler("xyz", [float(v) for v in before[0].split()])
    assert np.degrees((recorded * T.rotation[0].inv()).magnitude()) > 60


def test_other_recordings_are_clean_at_every_rate(recordings_folder):
    paths = [*recordings_folder.glob("kit_bimanual/*.xml"), *recordings_folder.glob("mmlfd_pouring/*.csv")]
    assert len(paths) >= 10
    for path in paths:
        if path.name.startswith("Open"):
            with pytest.raises(DemonstrationError, match=r"frames 0 to 11 .* of apple_juice_lid are damaged"):
                read_demonstration(path)
            continue
        demonstration = read_demonstration(path)
        if not path.name.startswith(("Stir", "Close", "Cut")):
            assert not any("damaged" in note for note in demonstration.notes)
        for rate in (100.0, 30.0, 10.0, 5.0):
            assert repair_demonstration(sampled := resample(demonstration, rate)) is sampled
