"""Problems that were loaded are pickled by the names they were loaded by."""

from __future__ import annotations

import copyreg
from typing import Any

from . import _core
from ._core import RobotProblem


def _loaded(reference: str, instance: tuple[int, int] | None, level: Any) -> RobotProblem:
    return _core.load_problem(reference, instance, level)


def _reduced(problem: RobotProblem) -> tuple[Any, ...]:
    if problem.reference is None:
        raise TypeError("a problem that was not loaded from a file or by its ID cannot be pickled")
    return _loaded, (problem.reference, problem.instance, problem.level)


copyreg.pickle(RobotProblem, _reduced)
