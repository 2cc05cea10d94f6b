"""Fixtures shared by all tests."""

import os
import textwrap
from collections.abc import Callable, Mapping
from pathlib import Path

import jaxtyping
import numpy as np
import pytest
from hypothesis import Phase, settings
from scipy.spatial.transform import RigidTransform, Rotation

# Shapes and number types in annotations are checked in tests, never in use. Left out is what is called in inner loops,
# where it would take too long: learning alone half as long again.
WHOLE_NUMBERS_TOO = "beartype.beartype(conf=beartype.BeartypeConf(is_pep484_tower=True))"  # where a float is meant
jaxtyping.install_import_hook(["sbam.constraints", "sbam.scene"], WHOLE_NUMBERS_TOO)

from sbam.demonstrations.scenes import starting_scene
from sbam.demonstrations.synthetic import built_in_demonstrations
from sbam.learning.learn import learn
from sbam.planning.plan import Plan, plan
from sbam.robots import Robot, load_robot
from sbam.scene import ObjectLibrary, Scene, upright_rotation
from sbam.tasks.action import Action

REPOSITORY = Path(__file__).parents[1]

settings.register_profile("no deadline", deadline=None)  # how long an example takes is the machine's affair
# An example that finds a planted fault need not be made small.
settings.register_profile("mutants", deadline=None, phases=(Phase.explicit, Phase.generate), database=None)
settings.load_profile("mutants" if "MUTANT_UNDER_TEST" in os.environ else "no deadline")


@pytest.fixture(scope="session")
def recordings_folder() -> Path:
    """Folder of third-party recordings (not part of the project); tests that need it skip where it is absent."""
    folder = Path(os.environ.get("SBAM_DATA", REPOSITORY.parent / "shared" / "data"))
    if not folder.is_dir():
        pytest.skip(f"third-party recordings not found at {folder}; set SBAM_DATA")
    return folder


@pytest.fixture
def distribution(tmp_path: Path) -> Callable[..., Path]:
    """``distribution(name, source, groups)``: a distribution with one module, in a folder to be put on the path.

    ``groups`` is group -> name -> object of the module.
    """

    def build(name: str, source: str, groups: Mapping[str, Mapping[str, str]]) -> Path:
        folder = tmp_path / f"site-{name}"
        module = name.replace("-", "_")
        about = folder / f"{module}-1.0.dist-info"
        about.mkdir(parents=True)
        (folder / f"{module}.py").write_text(textwrap.dedent(source), encoding="utf-8")
        (about / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.0\n")
        lines = [
            line
            for group, objects in groups.items()
            for line in (f"[{group}]", *(f"{key} = {module}:{value}" for key, value in objects.items()))
        ]
        (about / "entry_points.txt").write_text("\n".join(lines) + "\n")
        return folder

    return build


@pytest.fixture(scope="session")
def small_plan() -> Plan:
    """Pouring, learned from four of the built-in demonstrations and planned in another scene; not to be changed."""
    model = learn(built_in_demonstrations("pouring")[::3])
    return plan(model, starting_scene("built-in:pouring_new_layout"))


@pytest.fixture(scope="session")
def panda() -> Robot:
    """The bimanual Panda where it belongs in the agent frame."""
    return load_robot("panda_dual").placed_for(RigidTransform.identity())


@pytest.fixture(scope="session")
def within_limits() -> Callable[..., np.ndarray]:
    """``within_limits(robot, generator, count, share)``: random configurations, (count, n)."""

    def configurations(robot: Robot, generator: np.random.Generator, count: int, share: float = 0.9) -> np.ndarray:
        lower = np.where(np.isfinite(robot.lower), robot.lower, -np.pi)
        upper = np.where(np.isfinite(robot.upper), robot.upper, np.pi)
        middle, half = 0.5 * (lower + upper), 0.5 * share * (upper - lower)
        return generator.uniform(middle - half, middle + half, (count, len(lower)))

    return configurations


@pytest.fixture(scope="session")
def pour() -> Callable[..., Action]:
    """Builds a short pour: the mouth comes to ``aside`` and ``above`` the rim while the bottle tilts, and back."""
    library = ObjectLibrary.built_in()

    def build(tilt_deg: float = 96.0, aside: float = 0.015, above: float = 0.035, seconds: float = 2.4) -> Action:
        bottle, cup, table = library["apple_juice"], library["cup_large"], library["kitchen_sideboard"]
        time = np.arange(0.0, seconds, 0.01)
        course = np.clip(time / 0.8, 0.0, 1.0) * np.clip((seconds - time) / 0.6, 0.0, 1.0)
        turn = Rotation.from_rotvec(np.deg2rad(-tilt_deg) * course[:, None] * [0.0, 1.0, 0.0])
        turn = turn * upright_rotation(bottle.up, 0.0)
        stand = upright_rotation(cup.up, 0.0)
        held = RigidTransform.from_components([0.0, 0.0, 0.2], stand)
        way = np.column_stack([aside + 0.10 * (1.0 - course), 0.0 * course, above + 0.0 * course])
        mouth = held.apply(cup.region("pour into").center) + way
        position = mouth - turn.apply(bottle.region("pour from").center)
        top = upright_rotation(table.up, 0.0)
        scene = Scene(
            name="short pour",
            objects={"cup_large": cup, "apple_juice": bottle, "kitchen_sideboard": table},
            T_world_object={
                "cup_large": held,
                "apple_juice": RigidTransform.from_components(position[0], turn[0]),
                "kitchen_sideboard": RigidTransform.from_components(-top.apply(table.region("place onto").center), top),
            },
            T_world_agent=RigidTransform.identity(),
        )
        return Action(
            name="short pour",
            scene=scene,
            roles={},
            time=time,
            T_world_object={
                "apple_juice": RigidTransform.from_components(position, turn),
                "cup_large": RigidTransform.from_matrix(np.tile(held.as_matrix(), (len(time), 1, 1))),
            },
        )

    return build
