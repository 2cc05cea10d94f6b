from itertools import pairwise

import numpy as np
import pytest

from sbam.demonstrations.events import find_events
from sbam.demonstrations.holds import find_holds
from sbam.demonstrations.synthetic import built_in_demonstrations, generate_rolling
from sbam.errors import DemonstrationError
from sbam.scene.object_library import ObjectLibrary

PIN = ObjectLibrary.built_in()["rolling_pin"]
DEMONSTRATIONS = built_in_demonstrations("rolling")
RADIUS = 0.033
ids = [d.name for d in DEMONSTRATIONS]


def pin_in_agent(demonstration):
    return demonstration.T_world_agent.inv() * demonstration.T_world_object["rolling_pin"]


def moving(demonstration):
    events = {e.kind: e.time for e in find_events(demonstration)}
    return events["lift"], events["place"]


def test_eight_different_demonstrations():
    assert len(DEMONSTRATIONS) == 8 and len(set(ids)) == 8
    assert all(d.synthetic and d.objects == ("rolling_pin", "kitchen_sideboard") for d in DEMONSTRATIONS)
    assert len({d.duration for d in DEMONSTRATIONS}) > 5


def test_same_seed_same_demonstration():
    first, again = generate_rolling(5), generate_rolling(5)
    for name in first.objects:
        assert np.array_equal(first.T_world_object[name].as_matrix(), again.T_world_object[name].as_matrix())


@pytest.mark.parametrize("demonstration", DEMONSTRATIONS, ids=ids)
def test_pin_lies_across_before_the_agent_and_rests_on_the_table(demonstration):
    poses = pin_in_agent(demonstration)
    left, right = (poses.apply(PIN.region(f"handle {side}").center) for side in ("left", "right"))
    assert (right[:, 0] - left[:, 0]).min() > 0.35  # never turned round: the left handle at the agent's left
    lift, place = moving(demonstration)
    time = demonstration.time
    for still in (time < lift - 0.15, time > place + 0.15):
        assert still.sum() > 50
        assert np.abs(poses.translation[still, 2] - RADIUS).max() < 1e-9
        assert np.ptp(poses.translation[still], axis=0).max() < 1e-9
    assert 0.48 < poses.translation[0, 1] < 0.60
    assert np.linalg.norm(poses.translation[-1] - poses.translation[0]) < 0.045


@pytest.mark.parametrize("demonstration", DEMONSTRATIONS, ids=ids)
def test_pin_never_enters_the_table(demonstration):
    poses = pin_in_agent(demonstration)
    ends = np.stack([poses.apply([x, 0, 0])[:, 2] for x in (-0.17, 0.17)])
    assert ends.min() > RADIUS - 0.001


@pytest.mark.parametrize("strokes", [1, 4, 6])
def test_number_of_strokes(strokes):
    reversals = [e for e in find_events(generate_rolling(2, strokes=strokes)) if e.kind == "reversal"]
    assert len(reversals) == 2 * strokes - 1


def test_no_strokes_is_an_error():
    with pytest.raises(DemonstrationError, match="0 strokes; ask for 1 or more"):
        generate_rolling(2, strokes=0)


@pytest.mark.parametrize("demonstration", DEMONSTRATIONS, ids=ids)
def test_both_hands_hold_the_handles(demonstration):
    lift, place = moving(demonstration)
    held = (demonstration.time > lift) & (demonstration.time < place)
    for hand, side in (("left", -1), ("right", 1)):
        palm = (demonstration.T_world_object["rolling_pin"].inv() * demonstration.T_world_hand[hand]).translation[held]
        assert np.abs(palm[:, 0] - side * 0.19).max() < 0.02
        assert np.ptp(palm[:, 0]) < 0.015
        assert np.linalg.norm(palm[:, 1:], axis=1).min() > 0.02 and np.linalg.norm(palm[:, 1:], axis=1).max() < 0.06
    holds = find_holds(demonstration)
    assert sorted((h.hand, h.object) for h in holds) == [("left", "rolling_pin"), ("right", "rolling_pin")]


@pytest.mark.parametrize("demonstration", DEMONSTRATIONS, ids=ids)
def test_no_jumps_and_labels_in_order(demonstration):
    for poses in (*demonstration.T_world_object.values(), *demonstration.T_world_hand.values()):
        assert np.isfinite(poses.as_matrix()).all()
        assert np.linalg.norm(np.diff(poses.translation, axis=0), axis=1).max() < 0.015
        assert np.degrees((poses[:-1].inv() * poses[1:]).rotation.magnitude()).max() < 4.0
    for hand in ("left", "right"):
        labels = [label for label in demonstration.labels if label.hand == hand]
        actions = [label.action for label in labels]
        assert actions == ["Idle", "Approach", "Move", "RollOut", "Place", "Retreat", "Idle"]
        assert all(a.end == b.start for a, b in pairwise(labels))
