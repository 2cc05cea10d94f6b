"""The paper's similarity and damping, t_s and t_d, worked out by hand."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform

from sbam.constraints import Cartesian, RegionPair, RegionReference, Symbolic
from sbam.demonstrations.scenes import starting_scene
from sbam.learning.generalization import GeneralizedChange, GeneralizedChannel
from sbam.planning.bind import bind
from sbam.planning.keypoints.objective import build_problem
from sbam.planning.keypoints.state import RegionPoint, Workspace
from sbam.planning.keypoints.terms import Damping, Similarity, Smoothing
from sbam.planning.settings import PlanSettings
from sbam.planning.task import Task

HERE = RigidTransform.identity()
BOTTLE, CUP = "pour_from", "pour_into"
TIMES = np.array([0.0, 0.5, 0.7])  # s


@pytest.fixture
def regions(robot_named):
    """Two keypoints; three regions that stand still, 20 cm and 30 cm from each other."""
    positions = ([0.2, 0.3, 0.1], [0.0, 0.3, 0.1], [0.2, 0.6, 0.1])
    workspace = Workspace(robot_named("flying_hands"), [], [RegionPoint(-1, np.array(p)) for p in positions])
    return workspace.state(np.zeros((2, 14)))


def similarity(constraint, target, std) -> Similarity:
    """Region 0 - region 1 and, 1 cm shifted, region 0 - its own start."""
    target, std = np.array(target), np.array(std)
    return Similarity(
        constraint=constraint,
        pairs=("pair", "own start"),
        first=np.array([0, 0]),
        second=np.array([1, -1]),
        origin=np.array([[9.0, 9.0, 9.0], [0.1, 0.1, 0.1]]),
        shift=np.array([[0.0, 0.0, 0.0], [0.0, 0.01, 0.0]]),
        target=target,
        weight=constraint.weights(std, target),
    )


@pytest.mark.parametrize(
    ("mode", "std"),
    # A weight of 1/10 per mm: 1 / (1 + 9), or 1 / hypot(sqrt 75, 5).
    [("paper", 0.009), ("default", np.sqrt(75.0) / 1000.0)],
)
def test_similarity_is_a_sum_of_norms_and_not_of_squares(regions, mode, std):
    """The vectors are (200, 0, 0) and (100, 210, 0) mm.

    Off by (3, 4, 12) and (0, 0, 5) cm, then (6, 0, 8) and (2, 3, 6) cm: weighted 13, 5, 10 and 7.
    """
    pair, own = np.array([0.2, 0.0, 0.0]), np.array([0.1, 0.21, 0.0])
    off = np.array([[[0.03, 0.04, 0.12], [0.0, 0.0, 0.05]], [[-0.06, 0.0, 0.08], [0.02, -0.03, 0.06]]])
    target = np.array([[pair, own]] * 2) - off
    term = similarity(Cartesian(mode=mode), target, np.full((2, 2, 3), std))
    np.testing.assert_allclose(term.vector(regions), [[pair, own]] * 2, atol=1e-15)
    np.testing.assert_allclose(term.cost(regions), [[13.0, 5.0], [10.0, 7.0]])
    assert term.groups() == ("pair", "own start")
    # sqrt(s + e^2).
    smoothed = term.cost(regions, Smoothing(similarity=12.0, damping=7.0))
    np.testing.assert_allclose(smoothed[:, 1], [13.0, np.sqrt(49.0 + 144.0)])


def test_symbolic_similarity_of_a_pair(regions):
    """The quarter turn from behind to the right differs by 5 in four relations; weights of 1/2 make 5 of it."""
    symbolic = Symbolic(mode="paper")
    behind, there = symbolic.channels(np.array([0.0, 0.2, 0.0])), symbolic.channels(np.array([0.1, 0.21, 0.0]))
    term = similarity(symbolic, [[behind, there]] * 2, np.ones((2, 2, 8)))
    np.testing.assert_allclose(term.cost(regions), [[5.0, 0.0]] * 2, atol=1e-5)


def change(first: str, second: str, stds, units=("m", "m", "m")) -> GeneralizedChange:
    """A pair with standard deviations that do not change over time."""
    ends, count = np.array([0.0, 1.0]), np.ones(2, int)
    channels = tuple(
        GeneralizedChannel(str(i), unit, ends, np.full(2, 0.1), np.full(2, std), count)
        for i, (std, unit) in enumerate(zip(stds, units, strict=True))
    )
    region = {BOTTLE: "pour from", CUP: "pour into", "table": "place onto"}
    pair = RegionPair(RegionReference(first, region[first]), RegionReference(second, region[second]))
    names = {"m": "cartesian", "rad": "cylindrical", "log": "symbolic"}
    return GeneralizedChange(pair, names["rad" if "rad" in units else units[0]], channels)


def damping(task: Task, robot, **settings) -> tuple[Damping, tuple[str, ...]]:
    """The damping term of the problem that two hands without arms have with a task, at `TIMES`."""
    grasps = {(moved.role, moved.hands[0]): HERE for moved in task.moved}
    problem = build_problem(task, robot, grasps, PlanSettings(**settings), TIMES)
    (term,) = (term for term in problem.terms if isinstance(term, Damping))
    return term, tuple(moved.role for moved in task.moved)


@pytest.fixture(scope="module")
def tasks(model_of):
    scene = starting_scene("built-in:pouring_new_layout")
    return {mode: bind(model_of("pouring", mode=mode), scene) for mode in ("default", "paper")}


def with_changes(task: Task, constraint: str, changes) -> Task:
    return replace(task, model=replace(task.model, constraint=constraint, changes=tuple(changes)))


@pytest.mark.parametrize(
    ("constraint", "units", "stds", "expected"),
    [
        # Means: bottle - cup 20, bottle - table 40, cup - table 5 mm; so bottle 30, cup 12.5; times 1e-3 dt per mm.
        (
            "cartesian",
            ("m", "m", "m"),
            ((0.010, 0.020, 0.030), (0.040, 0.040, 0.040), (0.0, 0.005, 0.010)),
            {BOTTLE: (0.0, 15.0, 6.0), CUP: (0.0, 6.25, 2.5)},
        ),
        # (10 mm + 0.5 rad + 19.5 mm) / 3 = 10, (8 + 1 + 9) / 3 = 6, (3 + 0 + 0) / 3 = 1.
        (
            "cylindrical",
            ("m", "rad", "m"),
            ((0.010, 0.5, 0.0195), (0.008, 1.0, 0.009), (0.003, 0.0, 0.0)),
            {BOTTLE: (0.0, 4.0, 1.6), CUP: (0.0, 2.75, 1.1)},
        ),
        # Log units 0.4, 0.2, 0.6 times 1e-4 dt per mm.
        (
            "symbolic",
            ("log",) * 8,
            ((0.4,) * 8, (0.2,) * 8, (0.0, 1.2) * 4),
            {BOTTLE: (0.0, 0.015, 0.006), CUP: (0.0, 0.025, 0.010)},
        ),
    ],
)
def test_paper_damping_weighs_time_step_and_mean_deviation(tasks, robot_named, constraint, units, stds, expected):
    """w'_o, per m: proportional to the time step (0, 0.5, 0.2 s) and to the mean std of the pairs that touch o."""
    pairs = ((BOTTLE, CUP), (BOTTLE, "table"), (CUP, "table"))
    roles = {"table": next(r.name for r in tasks["paper"].model.roles if "place onto" in r.affordances)}
    changes = []
    for (first, second), std in zip(pairs, stds, strict=True):
        made = change(first, second, std, units)
        reference = made.pair.second
        assert reference is not None
        named = replace(reference, role=roles.get(reference.role, reference.role))
        changes.append(replace(made, pair=replace(made.pair, second=named)))
    term, order = damping(with_changes(tasks["paper"], constraint, changes), robot_named("flying_hands"))
    np.testing.assert_allclose(term.weight, np.transpose([expected[role] for role in order]), rtol=1e-12)


def test_default_damping_is_a_constant_per_metre(tasks, robot_named):
    term, order = damping(tasks["default"], robot_named("flying_hands"), damping=7.0)
    assert set(order) == {BOTTLE, CUP}
    np.testing.assert_array_equal(term.weight, np.full((3, 2), 7.0))
    assert PlanSettings().damping == 10.0


def test_damping_counts_the_way_from_the_start_and_from_keypoint_to_keypoint(tasks, robot_named):
    """Ways of 13 cm, then 5 cm, for the first object; 0 and 7 cm for the second; weights 10 and 20 per m."""
    task, robot = tasks["default"], robot_named("flying_hands")
    term, order = damping(task, robot)
    np.testing.assert_allclose(term.start, [moved.start.translation for moved in task.moved])
    assert (term.groups(), len(order)) == (order, 2)
    grasps = {(moved.role, moved.hands[0]): HERE for moved in task.moved}
    problem = build_problem(task, robot, grasps, PlanSettings(), TIMES)
    q = np.zeros((2, 14))
    ways = ([[0.03, 0.04, 0.12], [0.03, 0.01, 0.16]], [[0.0, 0.0, 0.0], [0.06, -0.02, 0.03]])
    for moved, start, way in zip(task.moved, term.start, ways, strict=True):
        q[:, robot.arms[moved.hands[0]].joint_indices[:3]] = start + np.array(way)
    found = Damping(order, np.array([[10.0, 20.0]] * 2), term.start).cost(problem.state(q))
    np.testing.assert_allclose(found, [[1.3, 0.0], [0.5, 1.4]], atol=1e-12)
