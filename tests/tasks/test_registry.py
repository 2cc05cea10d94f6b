import os
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

from sbam.errors import FileFormatError, SimulationError, UnknownNameError
from sbam.scene import AffordanceRegion, ObjectLibrary, ObjectModel, Primitive, Scene, upright_rotation
from sbam.simulation import simulate
from sbam.tasks import TASKS, find_task, load_task
from sbam.tasks.action import Action

STIRRING = Path(__file__).parents[2] / "examples" / "tasks" / "stirring.py"
UP = np.array([0.0, 0.0, 1.0])


def stirring(radius: float = 0.012, depth: float = 0.06) -> Action:
    """A spoon is lowered into a mug that stands on a table, goes round twice and comes out."""
    library = ObjectLibrary.built_in()
    mug, table = library["mug"], library["kitchen_sideboard"]
    rim = replace(mug.region("pour into"), affordance="stir in")
    mug = replace(mug, affordance_regions=(*mug.affordance_regions, rim))
    stick = Primitive("capsule", np.array([0.005, 0.09]), RigidTransform.from_translation([0, 0, 0.1]), np.ones(4))
    tip = AffordanceRegion("stir with", np.array([0.0, 0.0, 0.005]), np.full(2, 0.005), -UP)
    spoon = ObjectModel("spoon", (tip,), (stick,), (), UP, True, 0.05)
    time = np.arange(0.0, 3.0, 0.01)
    angle = 4 * np.pi * np.clip((time - 0.5) / 2.0, 0.0, 1.0)
    down = np.interp(time, [0.0, 0.4, 2.6, 3.0], [-0.03, depth, depth, -0.03])
    height = mug.profile.heights[-1] - down
    position = np.column_stack([radius * np.cos(angle), radius * np.sin(angle), height])
    turn = Rotation.from_quat(np.tile([0.0, 0.0, 0.0, 1.0], (len(time), 1)))
    path = RigidTransform.from_components(position, turn)
    top = upright_rotation(table.up, 0.0)
    scene = Scene(
        name="stirring",
        objects={"spoon": spoon, "mug": mug, "kitchen_sideboard": table},
        T_world_object={
            "spoon": path[0],
            "mug": RigidTransform.identity(),
            "kitchen_sideboard": RigidTransform.from_components(-top.apply(table.region("place onto").center), top),
        },
        T_world_agent=RigidTransform.identity(),
    )
    return Action("stirring", scene, {}, time, {"spoon": path})


def test_a_spoon_that_stays_in_the_cup_succeeds() -> None:
    result = simulate(stirring(), load_task(STIRRING))
    assert result.ok, result.problems
    assert result.values["turns"] == pytest.approx(2.0, abs=0.05)
    assert result.values["in the cup [s]"] > 2.0


def test_a_spoon_above_the_cup_or_pushing_it_fails() -> None:
    assert any("turns" in problem for problem in simulate(stirring(depth=-0.01), str(STIRRING)).problems)
    assert any("shoved" in problem for problem in simulate(stirring(radius=0.034), str(STIRRING)).problems)


def test_the_task_that_fits_is_found(pour) -> None:
    assert find_task(pour()).name == "pouring"
    assert find_task(pour(), "rolling") is TASKS["rolling"]
    with pytest.raises(UnknownNameError, match="pouring"):
        find_task(pour(), "puring")
    with pytest.raises(SimulationError, match="which task"):
        find_task(stirring())


def test_a_file_without_a_task_is_refused(tmp_path: Path) -> None:
    (tmp_path / "empty.py").write_text("TASK = 3\n")
    with pytest.raises(FileFormatError, match="TASK"):
        load_task(tmp_path / "empty.py")
    (tmp_path / "half.py").write_text(
        "from sbam.tasks import PhysicsTask\n"
        "class Half(PhysicsTask):\n    def judge(self, values, yardstick):\n        return []\n"
        "TASK = Half()\n"
    )
    with pytest.raises(FileFormatError, match=r"half.py.*abstract.*measure"):
        load_task(tmp_path / "half.py")
    with pytest.raises(FileFormatError, match="not a Python file"):
        load_task(tmp_path / "absent.py")


STANDING = """
from sbam.tasks import PhysicsTask

class Standing(PhysicsTask):
    name = "standing"
    affordances = ("pour into",)

    def measure(self, action, record):
        pose = record.T_world_object[action.object_with("pour into")]
        return {"leaning [share]": float(1.0 - pose[-1].rotation.as_matrix()[2, 1])}

    def judge(self, values, yardstick):
        return ["the cup has fallen over"] if values["leaning [share]"] > 0.1 else []
"""


@pytest.fixture
def installed(distribution) -> Callable[..., str]:
    """``installed(source, *arguments)``: what Python says beside a distribution that registers a task ``standing``."""

    def run(source: str, *arguments: str) -> str:
        folder = distribution("own-tasks", source, {"sbam.tasks": {"standing": "Standing"}})
        path = os.pathsep.join(filter(None, [str(folder), os.environ.get("PYTHONPATH")]))
        environment = {**os.environ, "PYTHONPATH": path}
        command = [sys.executable, *arguments]
        return subprocess.run(command, env=environment, check=True, capture_output=True, text=True, timeout=120).stdout

    return run


def test_a_task_of_another_distribution_is_tried_in_physics(installed) -> None:
    code = "import sbam; r = sbam.replay(sbam.built_in_demonstrations('pouring')[0], 'standing'); print(r.task, r.ok)"
    assert installed(STANDING, "-c", code).split() == ["standing", "True"]


def test_the_help_names_all_tasks(installed) -> None:
    said = installed("import nowhere_at_all", "-m", "sbam.cli", "simulate", "--help")
    assert "(known: pouring, rolling, standing)" in " ".join(said.replace("│", " ").split())


@pytest.mark.parametrize(
    ("source", "said"),
    [("import nowhere_at_all", "ModuleNotFoundError"), (STANDING.replace("def judge", "def judged"), "abstract")],
    ids=["import", "half a task"],
)
def test_a_registered_task_that_cannot_be_used_says_whose_it_is(installed, source: str, said: str) -> None:
    code = """
from sbam.errors import SbamError
from sbam.tasks import TASKS
assert TASKS["pouring"].name == "pouring"
try:
    TASKS["standing"]
except SbamError as error:
    print(error)
"""
    message = installed(source, "-c", code)
    for part in ("own-tasks 1.0", "sbam.tasks", "'standing'", said):
        assert part in message
