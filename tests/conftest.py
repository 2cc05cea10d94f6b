"""Fixtures shared by all tests."""

import os
from pathlib import Path

import pytest

REPOSITORY = Path(__file__).parents[1]


@pytest.fixture(scope="session")
def recordings_folder() -> Path:
    """Folder of third-party recordings (not part of the project); tests that need it skip where it is absent."""
    folder = Path(os.environ.get("SBAM_DATA", REPOSITORY.parent / "shared" / "data"))
    if not folder.is_dir():
        pytest.skip(f"third-party recordings not found at {folder}; set SBAM_DATA")
    return folder
