"""The recording holds the whole plan, needs no other file and leaves no server behind."""

import base64
import re
import socket
import threading
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest
import zstandard

from sbam.planning.plan import Plan
from sbam.viewer.playback import Playback
from sbam.viewer.recording import RATE, recording_html, write_recording


@pytest.fixture(scope="module")
def page(small_plan: Plan) -> str:
    return recording_html(small_plan)


@pytest.fixture(scope="module")
def recording(page: str) -> dict[str, Any]:
    """What the page plays: messages with their times, as the page's own program reads them."""
    embedded = re.search(r'__VISER_EMBED_DATA__="([^"]*)"', page)
    assert embedded
    content = base64.b64decode(embedded[1])
    inner = zstandard.ZstdDecompressor().decompressobj().decompress(content[8:])
    length = int.from_bytes(inner[:8], "little")
    return msgspec.msgpack.decode(inner[8 : 8 + length])


def pose_at(recording: dict[str, Any], node: str, key: str, time: float) -> np.ndarray:
    """The last value sent for a node up to a time."""
    kind = {"position": "SetPositionMessage", "wxyz": "SetOrientationMessage"}[key]
    values = [
        message[key]
        for at, message in recording["messages"]
        if at <= time + 1e-9 and message["type"] == kind and message["name"] == node
    ]
    return np.array(values[-1])


def test_objects_and_hands_move_as_planned(small_plan: Plan, recording: dict[str, Any]) -> None:
    playback = Playback(small_plan)
    for time in (0.0, 7.3, 10.0, small_plan.trajectory.duration):
        frames = playback.frames(np.round(time * RATE) / RATE)
        nodes = {f"/objects/{moved.name}": playback.body(moved.name) for moved in small_plan.task.moved}
        nodes |= {f"/robot/{side}_hand": playback.model.body(f"{side}_hand").id for side in ("left", "right")}
        for node, body in nodes.items():
            step = 0.7 / RATE  # the recording's own times are within a picture of these
            off = np.abs(pose_at(recording, node, "position", time + step) - frames.position[0, body]).max()
            turned = pose_at(recording, node, "wxyz", time + step) @ frames.quaternion_wxyz[0, body]
            assert off < 0.03
            assert abs(turned) > 0.995
    last = playback.frames(small_plan.trajectory.duration)
    end = pose_at(recording, "/objects/cup_large", "position", 1e9)
    assert np.abs(end - last.position[0, playback.body("cup_large")]).max() < 5e-5


def test_everything_that_is_seen_is_in_it(small_plan: Plan, recording: dict[str, Any]) -> None:
    names = {message["name"] for _, message in recording["messages"] if "name" in message}
    for name, model in small_plan.task.scene.objects.items():
        for affordance in model.affordances:
            assert {f"/objects/{name}/{affordance}", f"/objects/{name}/{affordance}/name"} <= names
    links = [f"/robot/{side}_link{k}" for side in ("left", "right") for k in range(8)]
    assert {*links, "/robot/left_finger_a", "/floor", "/phase"} <= names
    assert recording["durationSeconds"] == pytest.approx(small_plan.trajectory.duration, abs=1.5)
    texts = [str(message) for _, message in recording["messages"] if message.get("name") == "/phase"]
    assert any("left: manipulate, right: manipulate" in text for text in texts)
    assert all("synthetic" in text for text in texts if "manipulate" in text)


def test_it_is_one_small_file_that_loads_nothing(page: str) -> None:
    assert len(page) < 5_000_000
    assert not re.search(r'<(?:script|link|img)[^>]*(?:src|href)="(?!data:)[^"]', page)


def test_no_server_is_left_and_nothing_is_printed(small_plan: Plan, tmp_path: Path, capsys, monkeypatch) -> None:
    bound: list[tuple[str, int]] = []
    listen = socket.socket.listen

    def watched(self: socket.socket, *arguments: int) -> None:
        bound.append(self.getsockname()[:2])
        listen(self, *arguments)

    monkeypatch.setattr(socket.socket, "listen", watched)
    before = set(threading.enumerate())
    path = tmp_path / "new" / "plan.html"
    write_recording(small_plan, path)
    assert path.read_text(encoding="utf-8").lstrip().lower().startswith("<!doctype html>")
    assert bound
    for host, port in bound:
        assert host == "127.0.0.1"
        with socket.socket() as client:
            assert client.connect_ex((host, port)) != 0
    assert set(threading.enumerate()) <= before
    assert capsys.readouterr().out == ""
