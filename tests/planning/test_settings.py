"""Settings that make no sense are refused, above all those that would let a trajectory pass that is too fast."""

import pytest

from sbam.errors import SettingsError
from sbam.planning.settings import PlanSettings


@pytest.mark.parametrize(
    ("name", "values"),
    {
        "solver": ("nonsense", ""),
        "speed": (0.0, -0.5, 1.001, 2.0, float("nan")),
        "sample_rate": (0.0, -5.0, 1e6, float("nan"), float("inf")),
        "damping": (-1.0, float("nan")),
        "smoothness": (-1.0, float("inf")),
        "proximity": (-0.1,),
        "clearance": (-0.01, float("nan")),
        "prune": (-0.1, 1.5, float("nan")),
        "human_likeness": (-1.0, float("nan")),
    }.items(),
)
def test_nonsense_is_named(name, values):
    for value in values:
        with pytest.raises(SettingsError, match=f"setting '{name}' is .*; expected"):
            PlanSettings(**{name: value})


def test_bounds_are_allowed():
    PlanSettings(speed=1.0, sample_rate=10.0, damping=0.0, smoothness=0.0, clearance=0.0, human_likeness=0.0)
    assert PlanSettings().human_likeness is None
