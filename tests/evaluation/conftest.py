"""Results of folds, made by hand."""

from collections.abc import Callable

import pytest

from sbam.evaluation.fold import FoldResult
from sbam.evaluation.metrics import PairDistances

MOUTH_RIM = "pour from of pour_from -> pour into of pour_into"


@pytest.fixture
def result() -> Callable[..., FoldResult]:
    """Makes the result of a fold from the distances at its keypoints, mm, of one pair or of several by name."""

    def make(
        test: str, events: tuple[float, ...] | dict[str, tuple[float, ...]], condition: str = "a", **values: float
    ) -> FoldResult:
        by_pair = events if isinstance(events, dict) else {MOUTH_RIM: events}
        return FoldResult(
            condition=condition,
            constraint="cartesian",
            robot="flying_hands",
            test=test,
            synthetic=True,
            training=("other",),
            synthetic_training=True,
            objects=("apple_juice", "cup_large"),
            keypoints=len(next(iter(by_pair.values()))),
            pairs=tuple(
                PairDistances(pair, tuple(2.0 * one for one in found), found, (0.0,) * len(found), 5.0, 6.0)
                for pair, found in by_pair.items()
            ),
            values=values,
            problems=(),
            seconds={"plan": 1.0},
        )

    return make
