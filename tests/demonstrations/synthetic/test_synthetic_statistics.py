"""The synthetic demonstrations against recorded people: one set of bands that both must keep to."""

from functools import cache

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Slerp

from sbam.demonstrations.events import find_events
from sbam.demonstrations.readers import read_demonstration
from sbam.demonstrations.synthetic import built_in_demonstrations
from sbam.scene.object_library import ObjectLibrary

LIBRARY = ObjectLibrary.built_in()

# Statistic: lowest and highest value, s, m, m/s, deg and deg/s; all at the 10 Hz of the recordings.
POURING_BANDS = {
    "duration": (6.5, 11.6),
    "cup and bottle lifted apart by": (0.02, 1.8),
    "cup and bottle placed apart by": (0.0, 2.2),
    "bottle peak speed": (0.45, 1.10),
    "cup peak speed": (0.28, 0.62),
    "cup raised": (0.15, 0.30),
    "cup tilt while lifted": (3.0, 21.0),
    "cup tilt while pouring": (1.0, 8.5),
    "largest tilt": (78.5, 106.0),
    "tilt rise time (13 to 72 deg)": (0.27, 0.70),
    "tilt rate up": (110.0, 240.0),
    "tilt rate down": (120.0, 250.0),
    "pouring time (tilt over 60)": (0.9, 2.7),
    "tilt begins after lift": (0.1, 3.0),
    "mouth beside rim centre, mean": (0.008, 0.034),
    "mouth beside rim centre, most": (0.010, 0.036),
    "mouth above rim, mean": (0.026, 0.042),
    "mouth above rim, least": (0.024, 0.042),
    "cup put back beside its start": (0.0, 0.045),
    "bottle put back beside its start": (0.0, 0.045),
    "hand speed of the reach": (0.15, 1.1),
}
ROLLING_BANDS = {
    "duration": (8.0, 11.0),
    "reversals": (9, 9),
    "half-stroke length, mean": (0.110, 0.160),
    "half-stroke length, spread": (0.002, 0.025),
    "period": (0.86, 1.15),
    "peak speed of the strokes": (0.30, 0.65),
    "lowest while rolling": (-0.008, 0.006),
    "highest while rolling": (0.002, 0.012),
    "hop towards the body": (0.022, 0.045),
    "start ahead of the agent": (0.50, 0.60),
    "nearest to the agent": (0.23, 0.31),
    "largest yaw": (3.0, 18.0),
    "roll, all in all": (25.0, 150.0),
    "left hand along the axis": (-0.240, -0.165),
    "right hand along the axis": (0.165, 0.245),
    "put back beside its start": (0.0, 0.045),
}


def at_10_hz(demonstration, poses: RigidTransform) -> tuple[np.ndarray, RigidTransform]:
    """The same 10 Hz for recorded and synthetic ones, so that peak speeds compare."""
    time = np.arange(0.0, demonstration.time[-1], 0.1)
    position = np.stack([np.interp(time, demonstration.time, column) for column in poses.translation.T], axis=-1)
    return time, RigidTransform.from_components(position, Slerp(demonstration.time, poses.rotation)(time))


def speed(time, position):
    return np.linalg.norm(np.gradient(position, time, axis=0), axis=1)


def crossing(time, course, level):
    """When a course first rises over a level, linear between the samples."""
    k = int(np.argmax(course > level))
    return time[k - 1] + (level - course[k - 1]) / (course[k] - course[k - 1]) * (time[k] - time[k - 1])


def pouring_statistics(demonstration) -> dict[str, float]:
    cup_name = next(name for name in demonstration.objects if name.startswith("cup"))
    bottle_name = next(name for name in demonstration.objects if name in ("milk_small", "apple_juice"))
    cup_model, bottle_model = LIBRARY[cup_name], LIBRARY[bottle_name]
    time, cup = at_10_hz(demonstration, demonstration.T_world_object[cup_name])
    _, bottle = at_10_hz(demonstration, demonstration.T_world_object[bottle_name])
    _, hand = at_10_hz(demonstration, demonstration.T_world_hand["left"])
    events = {(e.object, e.kind): e.time for e in find_events(demonstration)}
    lift = events[bottle_name, "lift"]

    tilt, cup_tilt = (
        np.degrees(np.arccos(np.clip(poses.rotation.apply(model.up)[:, 2], -1, 1)))
        for poses, model in ((bottle, bottle_model), (cup, cup_model))
    )
    mouth, rim = bottle.apply(bottle_model.region("pour from").center), cup.apply(cup_model.region("pour into").center)
    beside, above = np.hypot(*(mouth - rim)[:, :2].T), (mouth - rim)[:, 2]
    pouring = tilt > 60
    steady = tilt > 75
    rate = np.gradient(tilt, time)
    return {
        "duration": demonstration.duration,
        "cup and bottle lifted apart by": abs(events[cup_name, "lift"] - lift),
        "cup and bottle placed apart by": abs(events[cup_name, "place"] - events[bottle_name, "place"]),
        "bottle peak speed": speed(time, bottle.translation).max(),
        "cup peak speed": speed(time, cup.translation).max(),
        "cup raised": np.ptp(cup.translation[:, 2]),
        "cup tilt while lifted": cup_tilt[time < crossing(time, tilt, 30)].max(),
        "cup tilt while pouring": cup_tilt[pouring].max(),
        "largest tilt": tilt.max(),
        "tilt rise time (13 to 72 deg)": crossing(time, tilt, 72) - crossing(time, tilt, 13),
        "tilt rate up": rate.max(),
        "tilt rate down": -rate.min(),
        "pouring time (tilt over 60)": 0.1 * pouring.sum(),
        "tilt begins after lift": crossing(time, tilt, 10) - lift,
        "mouth beside rim centre, mean": beside[steady].mean(),
        "mouth beside rim centre, most": beside[pouring].max(),
        "mouth above rim, mean": above[steady].mean(),
        "mouth above rim, least": above[pouring].min(),
        "cup put back beside its start": float(np.linalg.norm(cup.translation[-1] - cup.translation[0])),
        "bottle put back beside its start": float(np.linalg.norm(bottle.translation[-1] - bottle.translation[0])),
        "hand speed of the reach": speed(time, hand.translation)[time < events[cup_name, "lift"]].max(),
    }


def rolling_statistics(demonstration) -> dict[str, float]:
    T_agent_world = demonstration.T_world_agent.inv()
    time, pin = at_10_hz(demonstration, T_agent_world * demonstration.T_world_object["rolling_pin"])
    hands = {
        hand: (demonstration.T_world_object["rolling_pin"].inv() * poses).translation[:, 0]
        for hand, poses in demonstration.T_world_hand.items()
    }
    events = find_events(demonstration)
    lift, place = (next(e.time for e in events if e.kind == kind) for kind in ("lift", "place"))
    turns = np.array([e.time for e in events if e.kind == "reversal"])
    at_turns = np.interp(turns, time, pin.translation[:, 1])
    # The first stroke begins before the pin has been pressed down, so heights count from the first turn away.
    rolling = (time >= turns[1]) & (time <= turns[-1])
    height = pin.translation[:, 2] - pin.translation[0, 2]
    axis = pin.rotation.apply([1.0, 0, 0])
    yaw = np.degrees(np.arctan2(axis[:, 1], axis[:, 0]))
    matrix = pin.rotation.as_matrix()
    roll = np.degrees(np.unwrap(np.arctan2(matrix[:, 2, 1], matrix[:, 2, 2])))
    held = (demonstration.time > lift) & (demonstration.time < place)
    return {
        "duration": demonstration.duration,
        "reversals": len(turns),
        "half-stroke length, mean": np.abs(np.diff(at_turns)).mean(),
        "half-stroke length, spread": np.abs(np.diff(at_turns)).std(),
        "period": float(np.mean(turns[3:] - turns[1:-2])),
        "peak speed of the strokes": speed(time, pin.translation)[rolling].max(),
        "lowest while rolling": height[rolling].min(),
        "highest while rolling": height[rolling].max(),
        "hop towards the body": height[(time > lift) & (time < turns[0])].max(),
        "start ahead of the agent": pin.translation[0, 1],
        "nearest to the agent": pin.translation[:, 1].min(),
        "largest yaw": np.abs(yaw[rolling] - np.median(yaw)).max(),
        "roll, all in all": np.ptp(roll[(time > lift) & (time < place)]),
        "left hand along the axis": np.median(hands["left"][held]),
        "right hand along the axis": np.median(hands["right"][held]),
        "put back beside its start": float(np.linalg.norm(pin.translation[-1] - pin.translation[0])),
    }


KNOWN_DIFFERENCES = {
    # The recorded pin is tracked up to 4 mm lower while rolling than at rest; ours never enters the table.
    "lowest while rolling",
}

STATISTICS = {"pouring": (pouring_statistics, POURING_BANDS), "rolling": (rolling_statistics, ROLLING_BANDS)}
RECORDINGS = {"pouring": "Pour_files_motions_2967*.xml", "rolling": "RollOut_files_motions_3113*.xml"}


@cache
def synthetic_statistics(task):
    measure = STATISTICS[task][0]
    seeds = (0, 1) if task == "pouring" else (0,)
    return {d.name: measure(d) for seed in seeds for d in built_in_demonstrations(task, seed)}


def recorded_statistics(task, recordings_folder):
    paths = sorted((recordings_folder / "kit_bimanual").glob(RECORDINGS[task]))
    if not paths:
        pytest.skip(f"no recording {RECORDINGS[task]} in {recordings_folder}")
    return STATISTICS[task][0](read_demonstration(paths[0]))


def outside(statistics, bands):
    return {name: value for name, value in statistics.items() if not bands[name][0] <= value <= bands[name][1]}


@pytest.mark.parametrize("task", STATISTICS)
def test_every_synthetic_demonstration_keeps_to_the_bands(task):
    bands = STATISTICS[task][1]
    for name, statistics in synthetic_statistics(task).items():
        assert not outside(statistics, bands), name


@pytest.mark.parametrize("task", STATISTICS)
def test_recorded_people_keep_to_the_same_bands(task, recordings_folder):
    assert not outside(recorded_statistics(task, recordings_folder), STATISTICS[task][1])


@pytest.mark.parametrize("task", STATISTICS)
def test_recorded_person_is_not_an_outlier_among_the_synthetic(task, recordings_folder):
    """The recorded person lies within the range of the synthetic ones, or not farther beyond it than half its width."""
    recorded = recorded_statistics(task, recordings_folder)
    beyond = {}
    for name, value in recorded.items():
        values = [statistics[name] for statistics in synthetic_statistics(task).values()]
        outside_by = max(min(values) - value, value - max(values), 0.0)
        if outside_by > 0.5 * np.ptp(values) and name not in KNOWN_DIFFERENCES:
            beyond[name] = value
    assert not beyond


@pytest.mark.parametrize("task", STATISTICS)
def test_synthetic_people_vary(task):
    """No statistic but the number of strokes is the same in all: people never do a thing twice alike."""
    table = synthetic_statistics(task)
    for name in STATISTICS[task][1]:
        if name != "reversals":
            values = np.array([statistics[name] for statistics in table.values()])
            assert values.std() > 0.02 * np.abs(values).mean(), name
