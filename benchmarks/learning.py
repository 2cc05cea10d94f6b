"""How long learning takes: the pouring demonstrations, adding one, a long recording, growth, and memory."""

from __future__ import annotations

import os
from dataclasses import replace

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(variable, "1")

import numpy as np
from measuring import least_seconds, peak_megabytes
from scipy.spatial.transform import RigidTransform

from sbam.constraints import CONSTRAINT_TYPES
from sbam.demonstrations.demonstration import Demonstration
from sbam.demonstrations.synthetic import built_in_demonstrations, generate_rolling
from sbam.learning import LearningSettings, add_demonstration, learn

LIMITS = {"cartesian": 1.5, "cylindrical": 1.5, "symbolic": 4.0}
"""Seconds for the twelve pouring demonstrations."""


def row(what: str, taken: float, limit: float | None = None) -> None:
    verdict = "" if limit is None else f"  limit {limit:4.1f} s  {'ok' if taken <= limit else 'TOO SLOW'}"
    print(f"{what:<58}{taken:7.3f} s{verdict}")


def lasting(demonstration: Demonstration, times: int) -> Demonstration:
    """The same demonstration several times on end, with the objects where they were put down."""

    def again(poses: RigidTransform) -> RigidTransform:
        return RigidTransform.concatenate([poses] * times)

    step = demonstration.time[-1] + np.diff(demonstration.time).mean()
    return replace(
        demonstration,
        time=np.concatenate([demonstration.time + index * step for index in range(times)]),
        T_world_object={name: again(poses) for name, poses in demonstration.T_world_object.items()},
        T_world_hand={hand: again(poses) for hand, poses in demonstration.T_world_hand.items()},
        labels=(),
    )


def main() -> None:
    pouring = built_in_demonstrations("pouring")
    learn(pouring[:1])  # imports on first use
    print("Twelve pouring demonstrations, 100 Hz, three objects")
    for mode in ("default", "paper"):
        for name, limit in LIMITS.items():
            model = learn(pouring[:11], name, mode)
            pairs = len(model.changes)
            row(f"{mode}, {name}, {pairs} pairs", least_seconds(lambda c=name, m=mode: learn(pouring, c, m)), limit)
            row("  adding the twelfth", least_seconds(lambda m=model: add_demonstration(m, pouring[11])), 0.3)

    print("\nA single recording of 60 s at 100 Hz")
    long = generate_rolling(0, strokes=54)
    for name in LIMITS:
        row(f"default, {name}, {long.duration:.0f} s of rolling", least_seconds(lambda c=name: learn([long], c)), 5.0)

    print("\nGrowth (cartesian, default)")
    for times in (1, 2, 4, 8):
        demonstration = lasting(pouring[0], times)
        row(f"  {len(demonstration.time):5d} frames", least_seconds(lambda d=demonstration: learn([d])))
    for pairs, count in (("functional", 9), ("all", 10), ("all and own start", 14)):
        settings = replace(
            LearningSettings(), pairs="functional" if pairs == "functional" else "all", own_start_pairs=pairs != "all"
        )
        row(f"  {count:5d} pairs ({pairs})", least_seconds(lambda s=settings: learn(pouring, settings=s)))
    for count in (3, 6, 12, 24):
        again = tuple(replace(demonstration, name=f"{demonstration.name} again") for demonstration in pouring)
        demonstrations = (*pouring, *again)[:count]
        row(f"  {count:5d} demonstrations", least_seconds(lambda d=demonstrations: learn(d)))

    print("\nSpread by the paper's update rule, as a multiple of the exact one")
    for task in ("pouring", "rolling"):
        exact, over = (
            learn(built_in_demonstrations(task), settings=LearningSettings(update_rule=rule))
            for rule in ("welford", "paper")
        )
        times = np.linspace(0.0, exact.duration, 200)
        spreads = [[np.linalg.norm(c.at(times)[1], axis=1) for c in model.changes] for model in (exact, over)]
        ratio = np.concatenate([b[a > 1e-3] / a[a > 1e-3] for a, b in zip(*spreads, strict=True)])
        print(f"  {task:<56}{ratio.mean():7.2f}")

    print("\nMemory at most, beside the demonstrations themselves")
    for mode in ("default", "paper"):
        print(f"  {mode:<56}{peak_megabytes(lambda m=mode: learn(pouring, mode=m)):7.1f} MB")

    print("\nResidual and derivative at 30 keypoints of 10 pairs")
    d = np.random.default_rng(0).normal(scale=0.2, size=(30, 10, 3))
    for name, constraint in CONSTRAINT_TYPES.items():
        target = constraint.channels(d + 0.01)
        weight = constraint.weights(np.full_like(target, 0.02), target)

        def both(c=constraint, t=target, w=weight) -> None:
            for _ in range(100):
                c.residual(d, t, w, 1e-3)
                c.residual_jacobian(d, t, w, 1e-3)

        print(f"{name:<58}{least_seconds(both) * 1e4:7.1f} us")


if __name__ == "__main__":
    main()
