"""Small files in the formats that are read, built from a known motion."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation


@pytest.fixture
def motion() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Time (41,) s at 10 Hz, position (41, 3) mm and roll, pitch, yaw (41, 3) rad of something carried to the side."""
    time = np.arange(41) / 10
    phase = (1 - np.cos(np.pi * time / time[-1])) / 2
    position = np.stack([-300 + 50 * phase, 250 * phase, 880 + 200 * phase * (1 - phase)], axis=-1)
    return time, position, np.stack([1.57 + 0.5 * phase, 0.3 * phase, -0.4 + phase], axis=-1)


def measurement(time, position, angles) -> str:
    def element(tag, values):
        return "" if values is None else f"<{tag}>{' '.join(str(v) for v in values)}</{tag}>"

    return (
        f'<Measurement timestep="{time}">{element("RootPosition", position)}{element("RootRotation", angles)}'
        "</Measurement>"
    )


@pytest.fixture
def mmm_motion() -> Callable[..., str]:
    """Build the text of a motion with a ModelPose; None in place of a vector leaves the element out."""

    def build(name, time, position, angles, kind="object", head="", sensors="") -> str:
        data = "".join(measurement(*frame) for frame in zip(time, position, angles, strict=True))
        return (
            f'<Motion name="{name}" type="{kind}">{head}<Model path="no/such/{name}.xml"/><Sensors>'
            f'<Sensor type="MoCapMarker" version="1.0"><Configuration/></Sensor>'
            f'<Sensor type="ModelPose" version="1.0"><Configuration/><Data>{data}</Data></Sensor>{sensors}'
            "</Sensors></Motion>"
        )

    return build


@pytest.fixture
def write_mmm(tmp_path: Path) -> Callable[..., Path]:
    def write(*parts: str, name: str = "recording") -> Path:
        path = tmp_path / f"{name}.xml"
        path.write_text(f'<?xml version="1.0"?>\n<MMM version="2.0" name="x">{"".join(parts)}</MMM>')
        return path

    return write


@pytest.fixture
def table(mmm_motion) -> str:
    """A table that was tracked once."""
    return mmm_motion("kitchen_sideboard", [0.0], [(-350, -200, 855)], [(3.14159, 0, -1.55)])


@pytest.fixture
def write_csv(tmp_path: Path, motion) -> Callable[..., Path]:
    """Write a KIT CSV of a moving carton; ``change`` edits the dictionary of columns."""

    def write(change: Callable[[dict], None] = lambda columns: None) -> Path:
        time, position, angles = motion
        wxyz = Rotation.from_euler("xyz", angles).as_quat(scalar_first=True)
        columns: dict[str, list] = {"timestep": list(time)}
        columns |= {f"milk_small[{a}]": list(column) for a, column in zip("xyz", position.T, strict=True)}
        columns["comment"] = ["pouring, slowly"] * len(time)
        columns |= {
            f"milk_small[{a}]": list(column) for a, column in zip(("qw", "qx", "qy", "qz"), wxyz.T, strict=True)
        }
        change(columns)
        path = tmp_path / "recording.csv"
        rows = [",".join(columns), *(",".join(map(quoted, row)) for row in zip(*columns.values(), strict=True))]
        path.write_text("\n".join(rows) + "\n")
        return path

    def quoted(value) -> str:
        return f'"{value}"' if isinstance(value, str) else str(value)

    return write
