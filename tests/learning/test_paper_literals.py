"""The paper's segmentation, matching and incremental update, worked out by hand."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sbam.learning import LearningSettings
from sbam.learning.incremental import add_candidates, first_demonstration
from sbam.learning.segmentation import segment

WELFORD = LearningSettings.default()
PAPER = replace(WELFORD, update_rule="paper")


def test_the_final_pass_moves_a_point():
    """Areas, in one unit of time between samples.

    Chord 0-5: 5.6. Two chords meet at 1, 2, 3, 4: 6.5, 3.5, 2.667, 4. Chord 0-3: 2.667; at 1, 2: 1.5, 2.5. So top-down
    keeps 0, 1, 3, 5. The final pass leaves 1 (chord 0-3: 2.667); from 1 to 5, however, one chord is off by 6.5 and two
    that meet at 2, 3, 4 are by 1, 1.5, 4.
    """
    time, value = np.arange(6.0), np.array([1.0, 3.0, 0.0, 0.0, 1.0, 2.0])
    assert segment(time, value, 2.0).tolist() == [0, 1, 2, 5]
    assert segment(time, value, 2.0, knots=[3]).tolist() == [0, 1, 3, 5]


def by_the_book(time, value, threshold):
    """The paper's words, one sample after the other."""

    def area(first, last):
        chord = np.interp(time[first : last + 1], time[[first, last]], value[[first, last]])
        return np.trapezoid(np.abs(value[first : last + 1] - chord), time[first : last + 1])

    def split(first, last):
        return min(range(first + 1, last), key=lambda point: area(first, point) + area(point, last))

    def top_down(first, last):
        if last - first < 2 or area(first, last) <= threshold:
            return []
        point = split(first, last)
        return [*top_down(first, point), point, *top_down(point, last)]

    points = [0, *top_down(0, len(time) - 1), len(time) - 1]
    result = points[:1]
    for after in points[2:]:
        if area(result[-1], after) > threshold:
            result.append(split(result[-1], after))
    return [*result, points[-1]]


@settings(max_examples=150, deadline=None)
@given(seed=st.integers(0, 100_000), count=st.integers(3, 18), share=st.sampled_from([0.002, 0.02, 0.05, 0.1, 0.2]))
def test_segmentation_is_that_of_the_paper_s_words(seed, count, share):
    """Up to 18 samples every split is tried; beyond, splits are searched from coarse to fine."""
    generator = np.random.default_rng(seed)
    time = np.cumsum(generator.uniform(0.05, 0.3, count))
    value = np.cumsum(generator.normal(size=count))
    threshold = share * np.ptp(value) * np.ptp(time)
    assert segment(time, value, threshold).tolist() == by_the_book(time, value, threshold)


def learned(time, value, unit="m"):
    return first_demonstration("x", unit, np.array(time), np.array(value))


def added(channel, time, value, number=2, choices=WELFORD, anchors=None):
    return add_candidates(channel, np.array(time), np.array(value), number, choices, anchors)


def test_a_match_costs_time_and_value():
    """|dt| / duration + |dv| / amplitude, against two gaps of 0.14: a candidate 1 s of 10 s off costs 0.1 at least."""
    channel = learned([0.0, 4.0, 10.0], [0.0, 0.30, 0.0])
    choices = replace(WELFORD, gap_cost=0.14)
    near = added(channel, [0.0, 5.0, 10.0], [0.0, 0.30, 0.0], choices=choices)
    assert near.time.tolist() == [0.0, 4.5, 10.0]
    assert near.count.tolist() == [2, 2, 2]
    # 0.1 + 0.06 / 0.3 = 0.3 is more than two gaps, 0.28: keypoint and candidate stay apart.
    apart = added(channel, [0.0, 5.0, 10.0], [0.0, 0.24, 0.0], choices=choices)
    np.testing.assert_allclose(apart.time, [0.0, 4.0, 5.0, 10.0])
    assert apart.count.tolist() == [2, 1, 1, 2]
    # 0.1 + 0.05 / 0.3 = 0.267 is less.
    together = added(channel, [0.0, 5.0, 10.0], [0.0, 0.25, 0.0], choices=choices)
    assert together.time.tolist() == [0.0, 4.5, 10.0]
    assert together.mean[1] == pytest.approx(0.275)


def test_of_two_candidates_at_the_same_distance_in_time_the_one_with_the_value_is_the_match():
    channel = learned([0.0, 4.0, 10.0], [0.0, 0.30, 0.0])
    earlier = added(channel, [0.0, 3.5, 4.5, 10.0], [0.0, 0.30, 0.21, 0.0])
    later = added(channel, [0.0, 3.5, 4.5, 10.0], [0.0, 0.21, 0.30, 0.0])
    assert earlier.time[1] == 3.75
    assert later.time[2] == 4.25


def test_azimuths_that_differ_by_a_turn_match():
    channel = learned([0.0, 4.0, 10.0], [0.0, 3.0, 0.0], "rad")
    turned = added(channel, [0.0, 5.0, 10.0], [0.0, 3.0 - 2.0 * np.pi, 0.0])
    assert turned.count.tolist() == [2, 2, 2]
    np.testing.assert_allclose(turned.mean, [0.0, 3.0, 0.0], atol=1e-12)
    as_lengths = added(learned([0.0, 4.0, 10.0], [0.0, 3.0, 0.0]), [0.0, 5.0, 10.0], [0.0, 3.0 - 2.0 * np.pi, 0.0])
    assert as_lengths.count.tolist() == [2, 1, 1, 2]


@pytest.mark.parametrize(
    ("choices", "second", "third"),
    [
        # ((0.36 - 0.30)^2 / 1), then ((0.45 - 0.33)^2 + 0.06^2) / 2.
        (PAPER, 0.06, np.sqrt((0.0144 + 0.0036) / 2)),
        # Sample deviations of (0.30, 0.36) and of (0.30, 0.36, 0.45).
        (WELFORD, np.sqrt(0.0018), np.sqrt((0.07**2 + 0.01**2 + 0.08**2) / 2)),
    ],
    ids=["paper", "welford"],
)
def test_two_steps_of_the_update(choices, second, third):
    """t0' = t1 / n + t0 (n - 1) / n, the mean likewise."""
    channel = learned([0.0, 4.0, 10.0], [0.0, 0.30, 0.0])
    channel = added(channel, [0.0, 4.4, 10.0], [0.0, 0.36, 0.0], 2, choices)
    assert channel.time[1] == pytest.approx((4.0 + 4.4) / 2)
    assert (channel.mean[1], channel.std[1]) == (pytest.approx(0.33), pytest.approx(second))
    channel = added(channel, [0.0, 4.5, 10.0], [0.0, 0.45, 0.0], 3, choices)
    assert channel.time[1] == pytest.approx((4.5 + 2 * 4.2) / 3)
    assert (channel.mean[1], channel.std[1]) == (pytest.approx(0.37), pytest.approx(third))
    assert channel.count.tolist() == [3, 3, 3]


def test_a_candidate_without_a_partner_enters_between_its_neighbours():
    """Both know the lift at 2 s and 3 s; a candidate half way from there to the end enters half way, at 6 s.

    There the model has 0.1 +- 0.02, the demonstration 0.31: mean 0.17, and by Welford's rule
    std^2 = ((0.31 - 0.1)(0.31 - 0.17) + 0.02^2) / 2. Time: (6.5 + 2 6) / 3.
    """
    channel = replace(learned([0.0, 2.0, 10.0], [0.1, 0.1, 0.1]), std=np.full(3, 0.02))
    same = np.array([0, 1, 2]), np.array([0, 1, 3])
    found = added(channel, [0.0, 3.0, 6.5, 10.0], [0.1, 0.1, 0.31, 0.1], 3, anchors=same)
    np.testing.assert_allclose(found.time, [0.0, 7 / 3, 18.5 / 3, 10.0])
    assert found.mean[2] == pytest.approx(0.17)
    assert found.std[2] == pytest.approx(np.sqrt((0.21 * 0.14 + 0.0004) / 2))
    assert found.count.tolist() == [2, 2, 1, 2]


def test_a_candidate_at_a_keypoint_s_time_does_not_enter():
    """Unmatched for its value, but at the very time of a keypoint: one keypoint, with the candidate's value."""
    channel = learned([0.0, 5.0, 10.0], [0.0, 0.3, 0.0])
    found = added(channel, [0.0, 5.0, 10.0], [0.0, -0.3, 0.0])
    np.testing.assert_allclose(found.time, [0.0, 5.0, 10.0])
    assert found.count.tolist() == [2, 1, 2]
    assert found.mean[1] == pytest.approx(0.0)
