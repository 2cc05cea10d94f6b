from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

from sbam.scene import ObjectLibrary, Scene, upright_rotation
from sbam.simulation import simulate
from sbam.tasks import TASKS
from sbam.tasks.action import Action
from sbam.tasks.rolling.dough import THICKNESS, lay_dough

LIBRARY = ObjectLibrary.built_in()
RADIUS = 0.033


def rolling(raised: float = 0.0, thickness: float = 0.004, half_strokes: int = 4) -> Action:
    """The pin is drawn near over the dough, rolled to and fro, and put back; it may be held too high."""
    pin, table = LIBRARY["rolling_pin"], LIBRARY["kitchen_sideboard"]
    ahead = [0.55, 0.55] + [0.27 if i % 2 == 0 else 0.42 for i in range(half_strokes + 1)] + [0.55]
    knots = np.cumsum([0.0, 0.1, 0.7] + [0.5] * half_strokes + [0.7])
    time = np.arange(0.0, knots[-1], 0.01)
    y = np.interp(time, knots, ahead)
    down = np.interp(time, [knots[1], knots[1] + 0.3, knots[-2] + 0.3, knots[-1]], [0.0, 1.0, 1.0, 0.0])
    hop = 0.03 * (np.exp(-(((time - 0.5) / 0.2) ** 2)) + np.exp(-(((time - knots[-1] + 0.3) / 0.2) ** 2)))
    z = RADIUS + hop + down * (thickness + raised)
    position = np.column_stack([0.0 * y, y, z])
    turn = Rotation.from_quat(np.tile(upright_rotation(pin.up, 0.0).as_quat(), (len(time), 1)))
    top = upright_rotation(table.up, 0.0)
    table_at = np.array([0.0, 0.5, 0.0]) - top.apply(table.region("place onto").center)
    scene = Scene(
        name="short rolling",
        objects={"rolling_pin": pin, "kitchen_sideboard": table},
        T_world_object={
            "rolling_pin": RigidTransform.from_components(position[0], turn[0]),
            "kitchen_sideboard": RigidTransform.from_components(table_at, top),
        },
        T_world_agent=RigidTransform.identity(),
    )
    return Action("short rolling", scene, {}, time, {"rolling_pin": RigidTransform.from_components(position, turn)})


@pytest.fixture(scope="module")
def good():
    return simulate(rolling())


def test_dough_is_as_thin_as_the_pin_went_low(good) -> None:
    assert good.ok
    assert good.task == "rolling"
    assert good.values["thickness, mean [mm]"] == pytest.approx(4.0, abs=0.6)
    assert good.values["off the planned thickness, 95 % [mm]"] < 1.0
    assert good.values["half-strokes"] == 4
    assert 3.0 < good.values["force, most [N]"] < 120.0


def test_dough_only_gets_thinner(good) -> None:
    thickness = good.record.measured["thickness"]
    assert np.all(np.diff(thickness, axis=0) < 2e-4)
    assert thickness[0] == pytest.approx(THICKNESS, abs=1e-4)


def test_a_pin_one_centimetre_too_high_is_judged_a_failure(good) -> None:
    result = simulate(rolling(raised=0.01), yardstick=good.values)
    assert any("stays" in problem for problem in result.problems)
    assert result.values["force, most [N]"] == 0.0
    assert TASKS["rolling"].judge(result.values, None)


def test_strokes_that_are_left_out_are_missed(good) -> None:
    result = simulate(rolling(half_strokes=2), yardstick=good.values)
    assert any("half-strokes" in problem for problem in result.problems)


def test_planned_thickness_of_a_level_pin_is_its_height() -> None:
    action = rolling(thickness=0.005)
    dough = lay_dough(action, "rolling_pin")
    pressed = dough.pressed_by(action.poses("rolling_pin", np.arange(0.0, action.duration, 0.005)))
    assert np.median(pressed) == pytest.approx(0.005, abs=1e-4)
    far = action.scene.T_world_object["rolling_pin"]
    assert np.isinf(dough.pressed_by(RigidTransform.from_matrix(far.as_matrix()[None]))).all()


def test_force_and_slip_are_reported_in_plain_numbers(good) -> None:
    from sbam.simulation.report import simulation_report

    report = simulation_report(replace(good, warnings=("note",)))
    assert report["ok"] is True
    assert report["warnings"] == ["note"]
    assert len(report["values"]["profile"]["thickness [m]"]) == 160
