"""Partners of events where two are equally near in time."""

import numpy as np
import pytest

from sbam.demonstrations.events import Event
from sbam.learning.anchors import align_events

FORTH, ASIDE = np.array([0.0, 1.0, 0.0]), np.array([0.98, 0.2, 0.0])


def carried(*reversals) -> list[Event]:
    events = [("lift", 1.0, np.ones(1)), ("place", 5.0, np.ones(1))]
    events += [("reversal", time, direction) for time, direction in reversals]
    return [Event(kind, "pin", time, direction, 1.0) for kind, time, direction in events]


@pytest.mark.parametrize(("directions", "expected"), [((ASIDE, FORTH), 3.2), ((FORTH, ASIDE), 2.8)])
def test_the_event_in_the_same_direction_is_the_partner(directions, expected):
    """Both are a twentieth of the way from lift to place off; the other direction has a cosine of 0.2."""
    first = carried((3.0, FORTH))
    second = carried((2.8, directions[0]), (3.2, directions[1]))
    anchors = align_events([first, second], [6.0, 6.0])
    np.testing.assert_allclose(anchors.times[:, 2], [3.0, expected])


def test_no_partner_is_better_than_one_that_is_too_far():
    """A gap of 0.35 each: reversals 0.65 of the way apart are partners, 0.75 are not."""
    for share, found in ((0.65, True), (0.75, False)):
        first, second = carried((1.4, FORTH)), carried((1.4 + 4.0 * share, FORTH))
        assert ("reversal" in align_events([first, second], [6.0, 6.0]).kinds) == found
