import numpy as np
import pytest

from sbam.simulation import simulate
from sbam.tasks import TASKS


@pytest.fixture(scope="module")
def good(pour):
    return simulate(pour())


def test_a_good_pour_ends_in_the_cup(good) -> None:
    assert good.ok
    assert good.values["poured"] > 0.95
    assert good.values["in the cup"] == pytest.approx(good.values["poured"])
    assert good.values["spills"] == []


def test_shares_add_up_and_series_agree(good) -> None:
    values = good.values
    assert values["in the cup"] + values["spilled"] == pytest.approx(values["poured"])
    series = values["series"]
    assert {len(column) for column in series.values()} == {len(good.record.time)}
    assert max(series["tilt [deg]"]) == pytest.approx(96.0, abs=0.5)
    assert np.all(np.diff(series["poured"]) >= -1.0 / values["spheres"])
    assert min(series["mouth aside [mm]"]) == pytest.approx(15.0, abs=1.5)
    assert values["mouth above while tilted, least [mm]"] == pytest.approx(35.0, abs=1.5)


def test_nothing_leaves_before_the_tilt(good) -> None:
    assert good.values["flow begins [s]"] > 0.3


@pytest.mark.parametrize(
    ("change", "problem"),
    [({"aside": 0.015 + 0.05}, "spilled"), ({"tilt_deg": 96.0 - 40.0}, "poured")],
    ids=["spout 5 cm aside", "tilt 40 degrees short"],
)
def test_a_wrong_pour_is_judged_a_failure(pour, good, change, problem: str) -> None:
    result = simulate(pour(**change), yardstick=good.values)
    assert not result.ok
    assert any(problem in sentence for sentence in result.problems)
    assert TASKS[result.task].judge(result.values, None)


def test_a_spill_says_when_and_where(pour, good) -> None:
    result = simulate(pour(aside=0.065), yardstick=good.values)
    spills = result.values["spills"]
    assert len(spills) == round(result.values["spilled"] * result.values["spheres"])
    for spill in spills:
        assert 0.3 < spill["time [s]"] < 2.5
        assert spill["position in the agent frame [m]"][2] < 0.03  # came down on the table, whose top is at 0


def test_a_bottle_that_bumps_the_cup_is_reported(pour, good) -> None:
    assert not any("cup_large" in warning for warning in good.warnings)
    result = simulate(pour(above=-0.005))
    (contact,) = result.record.contacts
    assert {contact.first, contact.second} == {"cup_large", "apple_juice"}
    assert 0.0 < contact.time < 2.0
    assert any("touches" in warning for warning in result.warnings)
