import numpy as np
import pytest

from sbam.tasks.object_motion import region_path


def test_paths_of_regions(small_plan):
    table = region_path(small_plan, "place_onto", "place onto")
    assert table.shape == (len(small_plan.model_time), 3)
    assert np.ptp(table, axis=0).max() == 0.0
    assert table[0, 2] == pytest.approx(0.0, abs=1e-6)
    rim = region_path(small_plan, "pour_into", "pour into")
    start = small_plan.task.T_agent_object["cup_large"]
    np.testing.assert_allclose(rim[0], start.apply([0.0, 0.130, 0.0]), atol=1e-9)
