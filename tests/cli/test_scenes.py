"""Scenes are listed and written."""

import numpy as np

import sbam
from sbam.cli import main


def test_a_recording_as_scene_means_its_first_frame(learned, recording, here) -> None:
    assert main(["scenes", "write", str(recording), "-o", "scene.yaml"]) == 0
    scene = sbam.load_scene("scene.yaml")
    (demonstration,) = sbam.load(recording)
    for name, poses in demonstration.T_world_object.items():
        assert np.allclose(scene.T_world_object[name].as_matrix(), poses[0].as_matrix(), atol=1e-9)
    assert np.allclose(scene.T_world_agent.as_matrix(), demonstration.T_world_agent.as_matrix(), atol=1e-9)


def test_scenes_are_listed(capsys) -> None:
    assert main(["scenes", "list"]) == 0
    assert "built-in:pouring_new_layout" in capsys.readouterr().out
