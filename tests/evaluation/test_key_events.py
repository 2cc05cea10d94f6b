"""Key events against labels."""

import numpy as np
import pytest

from sbam.demonstrations.demonstration import Label
from sbam.demonstrations.synthetic import built_in_demonstrations
from sbam.evaluation.key_events import KeyEventErrors, key_event_errors, labelled_holds, pooled
from sbam.scene import ObjectLibrary


def test_holds_are_what_is_neither_idle_nor_on_the_way():
    demonstration = built_in_demonstrations("pouring")[0]
    actions = ["Idle", "Approach", "Lift", "Pour", "Retreat", "Lift"]
    labels = tuple(Label("left", float(i), float(i + 1), action) for i, action in enumerate(actions))
    from dataclasses import replace

    assert labelled_holds(replace(demonstration, labels=labels), "left") == [(2.0, 4.0), (5.0, 6.0)]
    assert labelled_holds(replace(demonstration, labels=labels), "right") == []


def test_events_are_found_near_the_labels_of_built_in_demonstrations():
    errors = [
        key_event_errors(built_in_demonstrations(task)[0], ObjectLibrary.built_in()) for task in ("pouring", "rolling")
    ]
    found = pooled(errors)
    assert found["grasps"][1] < 0.25
    assert found["releases"][1] < 0.25
    assert found["grasps"][2] == 4


def test_quantiles_ignore_what_was_not_found():
    errors = KeyEventErrors("x", np.array([-0.2, np.nan, 0.4]), np.array([np.nan]), np.array([0.1]), 0.3)
    found = pooled([errors])
    assert found["grasps"] == pytest.approx((0.3, 0.38, 2))
    assert "releases" not in found


def test_real_recordings_agree_with_their_labels(recordings_folder):
    from sbam import load

    folder = recordings_folder / "kit_bimanual"
    recordings = load([next(folder.glob(f"{action}_files*.xml")) for action in ("Pour", "RollOut")])
    found = pooled([key_event_errors(recording, ObjectLibrary.built_in()) for recording in recordings])
    assert found["grasps"][1] < 0.2
    assert found["releases"][1] < 0.2
