"""Demonstrations that all tests of the learning share."""

import pytest

from sbam.demonstrations.synthetic import built_in_demonstrations


@pytest.fixture(scope="session")
def pouring():
    return built_in_demonstrations("pouring")


@pytest.fixture(scope="session")
def rolling():
    return built_in_demonstrations("rolling")
