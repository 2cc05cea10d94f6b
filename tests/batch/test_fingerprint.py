import subprocess
import sys
from dataclasses import dataclass

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform

from sbam.batch.fingerprint import code_fingerprint, fingerprint


@dataclass(frozen=True)
class Point:
    x: float


@dataclass(frozen=True)
class Place:
    x: float


def test_different_values_never_look_alike() -> None:
    values = [
        None, 0, 0.0, False, "0", b"0", [0], [[0]], [0, 0], {"0": 0}, Point(0.0), Place(0.0), Point(1.0),
        np.zeros(1), np.zeros((1, 1)), np.zeros(1, dtype=int), RigidTransform.identity(),
        RigidTransform.from_translation([0.0, 0.0, 1e-12]), ["ab", "c"], ["a", "bc"],
    ]  # fmt: skip
    assert len({fingerprint(value) for value in values}) == len(values)
    assert len(fingerprint(*values)) == 64


def test_what_has_no_fingerprint_is_refused() -> None:
    with pytest.raises(TypeError, match="no fingerprint of object"):
        fingerprint(object())


def test_the_code_s_fingerprint_is_the_same_in_every_process() -> None:
    code = "from sbam.batch.fingerprint import code_fingerprint; print(code_fingerprint('evaluation'))"
    other = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert other.stdout.strip() == code_fingerprint("evaluation") != code_fingerprint("simulation")
