from pathlib import Path

import numpy as np
import pytest

from sbam.errors import RenderingError, SimulationError
from sbam.simulation import simulate
from sbam.simulation.film import images, write_film


@pytest.fixture(scope="module")
def short(pour):
    return simulate(pour(seconds=1.0))


@pytest.fixture(scope="module")
def first(short):
    try:
        return next(images(short, [0]))
    except RenderingError as error:
        pytest.skip(str(error))


def test_pictures_show_what_moves(short, first) -> None:
    assert first.shape == (480, 640, 3)
    assert first.std() > 10.0
    (later,) = images(short, [len(short.record.time) // 2])
    assert (np.abs(later.astype(int) - first).max(axis=-1) > 30).mean() > 0.001


def test_a_film_can_be_read_and_lasts_as_long_as_the_action(short, first, tmp_path: Path) -> None:
    av = pytest.importorskip("av")
    write_film(short, tmp_path / "film.mp4")
    with av.open(str(tmp_path / "film.mp4")) as container:
        (stream,) = container.streams.video
        assert stream.codec_context.name == "h264"
        frames = sum(1 for _ in container.decode(stream))
    assert frames / 25 == pytest.approx(short.record.time[-1], abs=0.1)


def test_a_film_for_web_pages_shows_a_stretch_from_near(short, first, tmp_path: Path) -> None:
    from PIL import Image

    write_film(short, tmp_path / "clip.webp", between=(0.2, 0.8), size=(160, 120), close=True)
    with Image.open(tmp_path / "clip.webp") as clip:
        assert clip.size == (160, 120)
        assert clip.n_frames == pytest.approx(0.6 * 12.5, abs=1)
        clip.seek(0)
        early = np.array(clip.convert("RGB")).astype(int)
        clip.seek(clip.n_frames - 1)
        assert np.abs(np.array(clip.convert("RGB")) - early).max() > 30


def test_moments_side_by_side(short, first, tmp_path: Path) -> None:
    write_film(short, tmp_path / "moments.png", view="above")
    assert (tmp_path / "moments.png").read_bytes().startswith(b"\x89PNG")


def test_another_suffix_is_refused(short, tmp_path: Path) -> None:
    with pytest.raises(SimulationError, match="mp4"):
        write_film(short, tmp_path / "film.gif")
    assert not list(tmp_path.iterdir())
