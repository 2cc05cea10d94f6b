from pathlib import Path

import numpy as np
import pytest

from sbam.errors import FileFormatError
from sbam.scene import ObjectLibrary, VesselProfile, load_object

OBJECTS = Path(__file__).parents[2] / "src/sbam/scene/objects"


@pytest.mark.parametrize("name", ["apple_juice", "milk_small", "bottle"])
def test_vessels_that_are_poured_from_are_filled(name: str) -> None:
    model = ObjectLibrary.built_in()[name]
    assert model.profile is not None
    assert model.profile.fill is not None
    mouth = model.region("pour from").center @ model.up
    assert model.profile.heights[-1] == pytest.approx(mouth)
    assert 30e-6 < model.profile.fill_volume < 80e-6


@pytest.mark.parametrize("name", ["cup_small", "cup_large", "mug"])
def test_cups_are_empty_and_as_high_as_their_rim(name: str) -> None:
    model = ObjectLibrary.built_in()[name]
    assert model.profile is not None
    assert model.profile.fill_volume == 0.0
    assert model.profile.heights[-1] == pytest.approx(model.region("pour into").center @ model.up)


def test_volume_of_a_frustum_filled_half() -> None:
    profile = VesselProfile(np.array([0.0, 0.1, 0.2]), np.array([0.02, 0.02, 0.04]), 0.003, fill=0.15)
    cylinder, frustum = np.pi * 0.02**2 * 0.1, np.pi / 3 * 0.05 * (0.02**2 + 0.02 * 0.03 + 0.03**2)
    assert profile.fill_volume == pytest.approx(cylinder + frustum)


def test_objects_without_a_profile_stay_as_they_were() -> None:
    assert ObjectLibrary.built_in()["rolling_pin"].profile is None


@pytest.mark.parametrize(
    ("old", "new", "where"),
    [
        ("[0.245, 0.0175]", "[0.130, 0.0175]", r"profile\.inner\[1\]\[0\]"),
        ("[0.245, 0.0175]", "[0.245, 0]", r"profile\.inner\[1\]\[1\]"),
        ("fill: 0.232", "fill: 0.300", r"profile\.fill"),
        ("wall: 0.003", "wall: 0", r"profile\.wall"),
        ("wall: 0.003", "walls: 0.003", "profile"),
    ],
)
def test_a_wrong_profile_is_refused_where_it_is(tmp_path: Path, old: str, new: str, where: str) -> None:
    text = (OBJECTS / "apple_juice.yaml").read_text()
    assert old in text
    path = tmp_path / "juice.yaml"
    path.write_text(text.replace(old, new))
    with pytest.raises(FileFormatError, match=where):
        load_object(path)
