"""Figures are written into files, without a window and without slowing down the import."""

import subprocess
import sys
from pathlib import Path

import pytest
from matplotlib.figure import Figure

from sbam.demonstrations.synthetic import built_in_demonstrations
from sbam.errors import OutputError, UnknownNameError
from sbam.learning import learn
from sbam.planning.plan import Plan
from sbam.plots import save_figure, write_model_plots, write_plan_plots


def test_a_plan_s_figures_are_written(small_plan: Plan, tmp_path: Path) -> None:
    paths = write_plan_plots(small_plan, tmp_path / "plots")
    assert {path.name for path in paths} == {"comparison.png", "trajectory.png", "scene_path.png"}
    for path in paths:
        assert path.read_bytes().startswith(b"\x89PNG")
        assert path.stat().st_size < 1_000_000


def test_a_model_s_figures_are_written(tmp_path: Path) -> None:
    demonstrations = built_in_demonstrations("pouring")[:2]
    paths = write_model_plots(learn(demonstrations, constraint="symbolic"), tmp_path, demonstrations)
    names = {"generalized_changes.png", "keypoints.png", "spatial_relations.png", "segmentation.png"}
    assert {path.name for path in paths} == names
    assert {path.name for path in tmp_path.iterdir()} == names


@pytest.mark.parametrize(("suffix", "start"), [("png", b"\x89PNG"), ("PDF", b"%PDF"), ("svg", b"<?xml")])
def test_the_suffix_names_the_format(tmp_path: Path, suffix: str, start: bytes) -> None:
    path = tmp_path / f"figure.{suffix}"
    save_figure(Figure(), path)
    assert path.read_bytes().startswith(start)


def test_other_formats_and_impossible_places_are_errors(tmp_path: Path) -> None:
    with pytest.raises(UnknownNameError, match=r"'\.gif'.*known: '\.png'"):
        save_figure(Figure(), tmp_path / "figure.gif")
    (tmp_path / "file").write_text("")
    with pytest.raises(OutputError):
        save_figure(Figure(), tmp_path / "file" / "figure.png")


def test_matplotlib_is_imported_only_when_something_is_drawn() -> None:
    program = "import sys, sbam.plots; print('matplotlib' in sys.modules)"
    run = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert run.stdout.strip() == "False"
