"""What the tests share."""

from __future__ import annotations

import numpy as np
import pytest

import modsearch

LEVER = np.sqrt(1.25)  # from a hinge at (0, 0, 0.5) to the target (1, 0, 1) of seed/fixed


@pytest.fixture(scope="session")
def fixed() -> modsearch.RobotProblem:
    """Reach (1, 0, 1) within 1 mm, without obstacles."""
    return modsearch.load_problem("seed/fixed")


@pytest.fixture(scope="session")
def obstacles() -> modsearch.RobotProblem:
    """A target among two spheres and a box."""
    return modsearch.load_problem("seed/random_obstacles", instance=(0, 3))


@pytest.fixture
def lever() -> modsearch.Design:
    """One hinge that just reaches the target of seed/fixed."""
    return modsearch.Design([("hinge", [0.5, LEVER])])
