"""The measure of what is put down fails where it should: a good plan with its objects' motion spoilt."""

import pytest
from scipy.spatial.transform import RigidTransform, Rotation

from sbam.tasks import measure_put_down


@pytest.mark.parametrize("role", ["pour_from", "pour_into"])
def test_put_down_elsewhere(small_plan, role, spoilt, shifted):
    assert measure_put_down(small_plan).ok
    last = slice(-500, None)
    measure = measure_put_down(spoilt(small_plan, role, shifted([0.0, 0.05, 0.0]), last))
    assert not measure.ok
    assert all(role in problem and "put down" in problem for problem in measure.problems)
    near = measure_put_down(spoilt(small_plan, role, shifted([0.0, 0.01, 0.0]), last))
    assert near.ok
    assert max(near.values.values()) == pytest.approx(10.0, abs=1.0)


def test_put_down_on_its_side(small_plan, spoilt):
    """Its foot is where it should be, its mouth is not."""

    def toppled(pose):
        return pose * RigidTransform.from_rotation(Rotation.from_euler("x", 90.0, degrees=True))

    measure = measure_put_down(spoilt(small_plan, "pour_from", toppled, slice(-500, None)))
    assert any(problem.startswith("pour from of pour_from") for problem in measure.problems)
