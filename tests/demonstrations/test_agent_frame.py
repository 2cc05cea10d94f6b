"""Where the agent stands in recordings that do not say it."""

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

from sbam.demonstrations.agent_frame import find_agent
from sbam.demonstrations.recording import Track
from sbam.scene.geometry import agent_heading_deg

SIDEBOARD = RigidTransform.from_components([-0.35, -0.2, 0.855], Rotation.from_euler("xz", [np.pi, -1.55]))


def at(x, y, z=0.0) -> RigidTransform:
    return RigidTransform.from_translation([x, y, z])


def person(heading_deg: float) -> Track:
    """Stands at (0.2, -0.1) but for one outlier, its local y forward."""
    position = np.tile([0.2, -0.1, 0.93], (9, 1))
    position[4] += 5
    rotation = Rotation.from_euler("z", np.full((9, 1), heading_deg - 90), degrees=True)
    return Track(np.arange(9.0), position, rotation.as_quat())


@pytest.mark.parametrize(
    ("recorded", "expected"),
    [(180, 180), (184, 180), (-171, 180), (91, 90), (3, 0), (-95, -90), (45, 45), (-120, -120)],
)
def test_heading_of_the_person_squared_to_the_world(recorded, expected):
    agent, note = find_agent({"kitchen_sideboard": SIDEBOARD}, person(recorded))
    off = agent_heading_deg(agent) - expected
    assert abs((off + 180) % 360 - 180) < 1e-6
    np.testing.assert_allclose(agent.translation[:2], [0.2, -0.1])
    assert "person's root" in note


def test_origin_is_on_the_table_top():
    agent, _ = find_agent({"kitchen_sideboard": SIDEBOARD, "cup_small": at(0, 0, 0.877)}, person(180))
    assert agent.translation[2] == pytest.approx(0.855 + 0.024, abs=0.003)


def test_kit_table_without_person():
    agent, note = find_agent(
        {"kitchen_sideboard": SIDEBOARD, "cup_small": at(-0.25, -0.2), "milk_small": at(-0.25, 0)}, None
    )
    np.testing.assert_allclose(agent.translation[:2], [0.2, -0.1])
    np.testing.assert_allclose(agent.rotation.as_matrix()[:, :2], [[0, -1], [1, 0], [0, 0]], atol=1e-12)
    assert "KIT" in note


def test_neither_person_nor_known_table():
    agent, note = find_agent({"bottle": at(0.6, 0, 0.2), "mug": at(0, 0), "table": at(5, 5, 0.01)}, None)
    np.testing.assert_allclose(agent.translation, [0.3, -0.45, 0.01])
    np.testing.assert_allclose(agent.rotation.as_matrix(), np.eye(3), atol=1e-12)
    assert "no person" in note
    unknown, note = find_agent({"teapot": at(0, 0, 0.9), "tray": at(0, 0, 0.8)}, None)
    assert unknown.translation[2] == pytest.approx(0.8)
    assert "lowest object" in note


def test_a_person_who_was_never_seen():
    lost = Track(np.arange(2.0), np.full((2, 3), np.nan), np.full((2, 4), np.nan))
    _, note = find_agent({"mug": at(0, 0)}, lost)
    assert "no person" in note
