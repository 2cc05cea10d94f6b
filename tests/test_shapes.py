"""Shapes in annotations are checked while tests run."""

import jaxtyping
import numpy as np
import pytest

from sbam.constraints import CONSTRAINT_TYPES
from sbam.scene.affordance_region import AffordanceRegion


def test_wrong_shape_of_an_argument_is_refused():
    with pytest.raises(jaxtyping.TypeCheckError, match="d"):
        CONSTRAINT_TYPES["cartesian"].channels(np.zeros((5, 2)))


def test_wrong_shape_and_number_type_of_a_field_are_refused():
    center, half_axes, normal = np.zeros(3), np.ones(2), np.array([0.0, 0.0, 1.0])
    AffordanceRegion("place", center, half_axes, normal)
    with pytest.raises(jaxtyping.TypeCheckError, match="half_axes"):
        AffordanceRegion("place", center, np.ones(3), normal)
    with pytest.raises(jaxtyping.TypeCheckError, match="center"):
        AffordanceRegion("place", np.zeros(3, dtype=int), half_axes, normal)
