"""Each kind of extension, registered by a distribution outside of SBAM, does the main job."""

import json
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import sbam
from sbam.planning.bind import bind
from sbam.planning.keypoints.free_flight import solve_free_flight
from sbam.planning.keypoints.terms import Term, TermContext

RECORDINGS = [f"built-in:synthetic_pouring_juice_right_{index}" for index in range(3)]

SPHERICAL = '''
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from sbam.constraints import ConstraintType


@dataclass(frozen=True)
class Spherical(ConstraintType):
    """Inclination, azimuth, radius: the length comes last."""

    name: ClassVar[str] = "spherical"
    channel_names: ClassVar[tuple[str, ...]] = ("theta", "phi", "r")
    channel_units: ClassVar[tuple[str, ...]] = ("rad", "rad", "m")

    def channels(self, d):
        level = np.hypot(d[..., 0], d[..., 1])
        return np.stack(
            [np.arctan2(level, d[..., 2]), np.arctan2(d[..., 1], d[..., 0]), np.linalg.norm(d, axis=-1)], axis=-1
        )

    def vector(self, channels):
        theta, phi, r = np.moveaxis(np.asarray(channels), -1, 0)
        level = r * np.sin(theta)
        return np.stack([level * np.cos(phi), level * np.sin(phi), r * np.cos(theta)], axis=-1)

    def jacobian(self, d):
        x, y, z = np.moveaxis(d, -1, 0)
        level, r = np.hypot(x, y) + 1e-9, np.linalg.norm(d, axis=-1) + 1e-9
        theta = np.stack([x * z / level, y * z / level, -level], axis=-1) / r[..., None] ** 2
        phi = np.stack([-y, x, np.zeros_like(x)], axis=-1) / level[..., None] ** 2
        return np.stack([theta, phi, d / r[..., None]], axis=-2)

    def residual(self, d, target, weight, delta_rho=0.0):
        return weight[..., 2:] * (d - self.vector(target))

    def residual_jacobian(self, d, target, weight, delta_rho=0.0):
        shape = np.broadcast_shapes(np.shape(d), np.shape(target))
        return np.broadcast_to(weight[..., 2:], shape)[..., None] * np.eye(3)

    def weights(self, std, target):
        return self._length_weight(np.repeat(self.spread(std, target)[..., None], 3, axis=-1))
'''

PULL = '''
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from sbam.planning.keypoints.terms import Term


@dataclass(frozen=True)
class Pull(Term):
    """Each carried object is pulled to 0.15 m above where it stands."""

    name: ClassVar[str] = "pull"
    objects: tuple[str, ...]
    goal: np.ndarray

    def residual(self, state, smoothing=None):
        return 4.0 * (state.object_position - self.goal)

    def jacobian(self, state, smoothing=None):
        return 4.0 * state.object_jacobian

    def groups(self):
        return self.objects

    def at(self, keypoint, previous):
        return self


def pull(context):
    start = np.array([moved.start.translation for moved in context.task.moved])
    return [Pull(context.roles, start + [0.0, 0.0, 0.15])]
'''

FORMATS = """
import json

import numpy as np

from sbam.demonstrations.readers.recording_format import RecordingFormat
from sbam.demonstrations.recording import Recording, Track
from sbam.demonstrations.writers.recording_writer import RecordingWriter


def recognises(content):
    return content.startswith(b"{\\"poses\\"")


def read(content, path):
    file = json.loads(content)
    time = np.array(file["time"])
    tracks = {n: Track(time, np.array(p), np.array(q)) for n, (p, q) in file["poses"].items()}
    return Recording(path.stem, tracks)


def encode(demonstration):
    poses = demonstration.T_world_object
    table = {n: (T.translation.tolist(), T.rotation.as_quat().tolist()) for n, T in poses.items()}
    return json.dumps({"poses": table, "time": demonstration.time.tolist()}).encode()


def plan(plan):
    return {"joints.txt": " ".join(plan.trajectory.joint_names).encode()}


READER = RecordingFormat("pose table", ".poses", recognises, read)
WRITER = RecordingWriter(".poses", encode)
"""


@pytest.fixture
def run(distribution, tmp_path) -> Callable[..., subprocess.CompletedProcess[str]]:
    """``run(arguments)``: the command line as a process, with the distributions that were built."""

    def build(*arguments: str) -> subprocess.CompletedProcess[str]:
        sites = [str(path) for path in sorted(tmp_path.glob("site-*"))]
        source = str(Path(sbam.__file__).parents[1])
        environment = {**os.environ, "PYTHONPATH": os.pathsep.join([*sites, source]), "COLUMNS": "300"}
        command = [sys.executable, "-m", "sbam.cli", *arguments]
        return subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, timeout=300)

    return build


def succeeded(done: subprocess.CompletedProcess[str]) -> str:
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.parametrize("mode", ["default", "paper"])
def test_a_constraint_type_is_learned_shown_and_planned(distribution, run, tmp_path, mode) -> None:
    distribution("sbam-spherical", SPHERICAL, {"sbam.constraints": {"spherical": "Spherical"}})
    assert "spherical" in succeeded(run("learn", "--help"))
    succeeded(run("learn", *RECORDINGS, "-o", "model.json", "--constraints", "spherical", "--mode", mode))
    succeeded(run("show", "model.json", "--json", "shown.json"))
    pairs = json.loads((tmp_path / "shown.json").read_text())["pairs"]
    spherical = [pair for pair in pairs if pair["constraint"] == "spherical"]
    assert spherical and [channel["unit"] for channel in spherical[0]["channels"]] == ["rad", "rad", "m"]
    # Spreads of all metric pairs are measured by one layout, in metres.
    assert len({pair["layout_spread"] for pair in pairs}) == 1 and pairs[0]["layout_spread"] < 1.0
    planned = run(
        "plan", "model.json", "--scene", "built-in:pouring_new_layout",
        "-o", "out", "--json", "plan.json", "--keep-failed",
    )  # fmt: skip
    assert planned.returncode in (0, 1), planned.stderr
    report = json.loads((tmp_path / "plan.json").read_text())
    assert report["model"]["constraint"] == "spherical" and np.isfinite(report["objective"])
    assert (tmp_path / "out" / "trajectory.npz").exists()


def test_a_term_is_switched_on_by_name_and_a_plan_written_in_another_format(
    distribution, run, tmp_path, model_file
) -> None:
    distribution("sbam-pull", PULL, {"sbam.terms": {"pull": "pull"}})
    distribution("sbam-joints", FORMATS, {"sbam.plan_writers": {"joints": "plan"}})
    shown = succeeded(run("plan", "--help"))
    assert "{pull}" in shown and "{npz,csv,ros,joints}" in shown
    run(
        "plan", str(model_file), "--scene", "built-in:pouring_new_layout",
        "-o", "out", "--json", "plan.json", "--keep-failed", "--terms", "pull", "--formats", "npz", "joints",
    )  # fmt: skip
    report = json.loads((tmp_path / "plan.json").read_text())
    terms = report["keypoints"][5]["terms"]
    assert set(terms["pull"]) == {"pour_from", "pour_into"}
    task = bind(sbam.load_model(model_file), sbam.load_scene("built-in:pouring_new_layout"))
    without, _ = solve_free_flight(task, sbam.PlanSettings())
    assert report["objective_without_robot"] > without.objective + 1.0
    assert {path.name for path in (tmp_path / "out").iterdir()} >= {"joints.txt", "trajectory.npz"}
    assert (tmp_path / "out" / "joints.txt").read_text().startswith("left_joint1 left_joint2")


def test_recordings_are_read_and_written_in_another_format(distribution, run, tmp_path) -> None:
    groups = {"sbam.readers": {"poses": "READER"}, "sbam.writers": {"poses": "WRITER"}}
    distribution("sbam-poses", FORMATS, groups)
    assert "poses" in succeeded(run("recordings", "write", "--help"))
    succeeded(run("recordings", "write", RECORDINGS[0], "-o", "written", "--format", "poses"))
    assert [path.suffix for path in (tmp_path / "written").iterdir()] == [".poses"]
    succeeded(run("recordings", "info", "written", "--json", "info.json"))
    (info,) = json.loads((tmp_path / "info.json").read_text())["recordings"]
    assert "apple_juice" in json.dumps(info)


BROKEN = {
    "sbam.constraints": {"gone": "Gone", "cylindrical": "number"},
    "sbam.terms": {"seven": "number"},
    "sbam.readers": {"seven": "number"},
    "sbam.writers": {"seven": "number"},
    "sbam.plan_writers": {"seven": "number"},
}


def test_a_broken_extension_disturbs_only_those_who_ask_for_it(distribution, run, tmp_path) -> None:
    distribution("sbam-broken", "number = 7", BROKEN)
    succeeded(run("--help"))
    succeeded(run("learn", *RECORDINGS[:1], "-o", "model.json"))
    succeeded(run("recordings", "write", RECORDINGS[0], "-o", "written"))
    succeeded(run("recordings", "info", "written"))
    plan = ["plan", "model.json", "--scene", "built-in:pouring_new_layout", "-o", "out"]
    for arguments, name, said in (
        (["learn", RECORDINGS[0], "-o", "x.json", "--constraints", "gone"], "'gone'", "AttributeError"),
        (["learn", RECORDINGS[0], "-o", "x.json", "--constraints", "cylindrical"], "'cylindrical'", "sbam has one"),
        (["recordings", "write", RECORDINGS[0], "-o", "x", "--format", "seven"], "'seven'", "RecordingWriter"),
        ([*plan, "--terms", "seven"], "'seven'", "expected TermFactory"),
        ([*plan, "--keep-failed", "--formats", "seven"], "'seven'", "expected PlanWriter"),
    ):
        done = run(*arguments)
        assert done.returncode == 1, done.stderr
        assert "sbam-broken 1.0" in done.stderr and name in done.stderr and said in done.stderr
        assert "Traceback" not in done.stderr and "fault of sbam" not in done.stderr
    (tmp_path / "other.odd").write_text("odd")
    assert "RecordingFormat" in run("recordings", "info", "other.odd").stderr


@pytest.fixture(scope="module")
def model_file(tmp_path_factory) -> Path:
    path = tmp_path_factory.mktemp("model") / "model.json"
    sbam.save_model(sbam.learn(sbam.load(RECORDINGS)), path)
    return path


class Upright(Term):
    """The second joint of each arm near a value; it knows nothing but the robot."""

    name = "upright"
    about_posture = True

    def residual(self, state, smoothing=None):
        return 0.5 * (state.configurations[:, None, 1:2] - 0.2)

    def jacobian(self, state, smoothing=None):
        jacobian = np.zeros((*state.configurations.shape[:1], 1, 1, state.configurations.shape[1]))
        jacobian[..., 1] = 0.5
        return jacobian

    def groups(self):
        return (self.name,)

    def at(self, keypoint, previous):
        return self


def test_terms_of_a_library_user(model_file) -> None:
    asked: list[bool] = []

    def make(context: TermContext) -> list[Term]:
        asked.append(context.free_flight)
        return [Upright()]

    scene = sbam.load_scene("built-in:pouring_new_layout")
    plan = sbam.plan(sbam.load_model(model_file), scene, terms=[make])
    assert plan.settings.terms == (make,)
    assert "upright" in plan.solution.terms and "upright" not in plan.free_flight.terms
    assert asked[0] is True and asked.count(False) > 1, "the choice of grasps asks too"


def test_what_makes_no_terms_is_refused(model_file) -> None:
    scene = sbam.load_scene("built-in:pouring_new_layout")
    model = sbam.load_model(model_file)
    with pytest.raises(sbam.SbamError, match="not one term"):
        sbam.plan(model, scene, terms=[lambda context: Upright()])
    with pytest.raises(sbam.SbamError, match="unknown term 'nothing'"):
        sbam.PlanSettings(terms=("nothing",))
