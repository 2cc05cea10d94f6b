"""The map of places of a base."""

import numpy as np
from scipy.spatial.transform import RigidTransform

from sbam.demonstrations.scenes import starting_scene
from sbam.planning.bind import bind
from sbam.planning.placement.search import BaseMap, Place
from sbam.plots import plot_base_map
from sbam.robots import load_robot


def test_the_map_can_be_read(small_plan, assert_readable):
    """Reached and missed places, some without room, the best one turned."""
    right, forward, turn = np.linspace(-0.4, 0.4, 9), np.linspace(-0.5, 0.5, 11), np.array([-30.0, 0.0, 30.0])
    miss = np.clip(-forward[None, :, None] + 0.2 * right + 0.001 * turn[:, None, None], 0, None)
    miss[miss < 0.05] = 0.0
    place = Place(0.1, 0.2, 25.0, {("cup", "left"): 0.0}, 0.3, planned=True)
    found = BaseMap(
        robot=load_robot("panda_dual").placed_for(RigidTransform.identity()),
        task=bind(small_plan.task.model, starting_scene("built-in:pouring_new_layout")),
        right=right,
        forward=forward,
        turn=turn,
        miss=miss,
        share=np.where(miss == 0, 0.4, 0.0),
        room=np.broadcast_to(forward[:, None] < 0.3, miss.shape),
        here=Place(0.0, 0.0, 0.0, {("cup", "left"): 0.1}, 0.0, planned=False),
        base=place,
        objects=None,
    )
    figure = plot_base_map(found)
    assert_readable(figure)
    assert [axes.get_title() for axes in figure.axes[:3]] == [
        "turned by -30\u00b0",
        "not turned",
        "turned by +30\u00b0",
    ]
    stars = [sum(line.get_marker() == "*" for line in axes.get_lines()) for axes in figure.axes[:3]]
    assert stars == [0, 0, 1]
