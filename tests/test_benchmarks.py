"""The comparison of benchmarks says what became worse, and says what is wrong with a baseline."""

import importlib
import json
import sys
import time
from pathlib import Path

import pytest

from sbam.errors import FileFormatError

BENCHMARKS = Path(__file__).parents[1] / "benchmarks"


@pytest.fixture(scope="module")
def compare():
    """The module `benchmarks/compare.py`."""
    sys.path.insert(0, str(BENCHMARKS))
    try:
        yield importlib.import_module("compare")
    finally:
        sys.path.remove(str(BENCHMARKS))


def busy(seconds: float) -> None:
    end = time.process_time() + seconds
    while time.process_time() < end:
        pass


def test_the_stored_baseline_can_be_read_and_is_not_worse_than_itself(compare):
    baseline = compare.read_baseline(compare.BASELINE)
    assert any(name.startswith("keypoints, symbolic") for name in baseline)
    assert compare.worsened(baseline, baseline) == []


def test_what_is_slower_is_named_with_both_figures(compare):
    (line,) = compare.worsened({"plan, pouring": 140.0, "learn": 10.0}, {"plan, pouring": 100.0, "learn": 10.0})
    assert line == "plan, pouring: 100 -> 140 (+40.0 %)"


@pytest.mark.parametrize(("name", "allowed"), [("plan, pouring", 0.25), ("plan: MB", 0.25), ("keypoints: J", 1e-3)])
def test_noise_is_tolerated_and_no_more(compare, name, allowed):
    """Times and memory may grow by a quarter, objectives by a thousandth; everything may shrink."""
    assert compare.worsened({name: 80.0 * (1.0 + 0.9 * allowed)}, {name: 80.0}) == []
    assert compare.worsened({name: 40.0}, {name: 80.0}) == []
    assert len(compare.worsened({name: 80.0 * (1.0 + 1.1 * allowed)}, {name: 80.0})) == 1


def test_what_the_baseline_does_not_know_is_not_worse(compare):
    assert compare.worsened({"new": 1e9}, {"old": 1.0}) == []


def test_a_ratio_is_that_of_the_times(compare):
    assert compare.ratio(lambda: busy(0.02), 3, lambda: busy(0.001)) == pytest.approx(20.0, rel=0.2)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (None, "cannot be read"),
        ("", "is not JSON"),
        ('{"plan": 1.0', "is not JSON"),
        ("[1.0]", "is of type list"),
        ('{"plan": "fast"}', r"\$\['plan'\]: is 'fast' \(expected a positive number\)"),
        ('{"plan": -1.0}', "expected a positive number"),
        ('{"plan": NaN}', "expected a positive number"),
        ('{"plan": true}', "expected a positive number"),
    ],
)
def test_a_missing_or_broken_baseline_is_a_clear_error(compare, tmp_path, text, says):
    path = tmp_path / "baseline.json"
    if text is not None:
        path.write_text(text)
    with pytest.raises(FileFormatError, match=says) as caught:
        compare.read_baseline(path)
    assert str(path) in str(caught.value)


def test_the_command_refuses_a_broken_baseline_before_it_measures(compare, tmp_path, monkeypatch, capsys):
    path = tmp_path / "baseline.json"
    monkeypatch.setattr(sys, "argv", ["compare.py", "--baseline", str(path)])
    monkeypatch.setattr(compare, "measure", lambda baseline: pytest.fail("measured"))
    with pytest.raises(SystemExit) as caught:
        compare.main()
    assert caught.value.code == 2
    assert str(path) in capsys.readouterr().err


@pytest.mark.parametrize(("now", "code"), [(100.0, 0), (150.0, 1)])
def test_the_command_fails_if_something_became_worse(compare, tmp_path, monkeypatch, capsys, now, code):
    path = tmp_path / "baseline.json"
    path.write_text(json.dumps({"plan": 100.0}))
    monkeypatch.setattr(sys, "argv", ["compare.py", "--baseline", str(path)])
    monkeypatch.setattr(compare, "measure", lambda baseline: {"plan": now})
    assert compare.main() == code
    assert ("plan: 100 -> 150" in capsys.readouterr().out) == bool(code)
    assert json.loads(path.read_text()) == {"plan": 100.0}


def test_update_needs_no_baseline_and_writes_one(compare, tmp_path, monkeypatch):
    path = tmp_path / "baseline.json"
    monkeypatch.setattr(sys, "argv", ["compare.py", "--baseline", str(path), "--update"])
    monkeypatch.setattr(compare, "measure", lambda baseline: {"plan": 3.0})
    assert compare.main() == 0
    assert compare.read_baseline(path) == {"plan": 3.0}
