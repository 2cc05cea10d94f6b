"""Matching the keypoints of two polylines (paper, section III-C: "similar to dynamic time warping")."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float, Int

_CERTAIN = -1e6
"""Cost of a match that is given, so low that no other can be worth breaking it."""


def align(
    cost: Float[np.ndarray, "rows columns"],
    gap: float,
    given: tuple[Int[np.ndarray, " given"], Int[np.ndarray, " given"]],
) -> Int[np.ndarray, "matches 2"]:
    """Cheapest monotone one-to-one matching with gaps (Needleman-Wunsch).

    Args:
        cost: of matching each row with each column.
        gap: cost of leaving one row or column without a partner.
        given: rows and columns, each increasing, that are matched in any case.

    Returns:
        Matched rows and columns, both strictly increasing.
    """
    cost = cost.copy()
    cost[given] = _CERTAIN
    rows, columns = cost.shape
    gaps = gap * np.arange(columns + 1)
    total = np.empty((rows + 1, columns + 1))
    total[0] = gaps
    for row in range(rows):
        # Best without a gap in this row; a gap in the row then carries it to the right: a running minimum.
        total[row + 1] = total[row] + gap
        np.minimum(total[row + 1, 1:], total[row, :-1] + cost[row], out=total[row + 1, 1:])
        total[row + 1] = np.minimum.accumulate(total[row + 1] - gaps) + gaps
    return _trace(total, cost, gap)


def _trace(
    total: Float[np.ndarray, "_ _"], cost: Float[np.ndarray, "rows columns"], gap: float
) -> Int[np.ndarray, "matches 2"]:
    pairs = []
    row, column = cost.shape
    while row > 0 and column > 0:
        match = total[row - 1, column - 1] + cost[row - 1, column - 1]
        upwards = total[row - 1, column] + gap
        leftwards = total[row, column - 1] + gap
        if match <= upwards and match <= leftwards:
            row, column = row - 1, column - 1
            pairs.append((row, column))
        elif upwards <= leftwards:
            row -= 1
        else:
            column -= 1
    return np.array(pairs[::-1], dtype=np.int64).reshape(-1, 2)
