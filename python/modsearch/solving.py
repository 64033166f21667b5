"""Searching for designs, and looking at them."""

from __future__ import annotations

import math
import os
import sys
from collections.abc import Callable
from typing import Literal, NamedTuple

from . import _core
from ._core import DesignProblem, Evaluation, RobotProblem, Solver, Verification
from .solution import Bound, Solution
from .typing import DesignLike


class Progress(NamedTuple):
    """How far a search has come."""

    evaluations: int
    seconds: float
    score: float | None
    """Of the best design so far; None before the first."""
    achieved: bool
    """The best design does what was asked."""
    failed: int
    """Evaluations that gave NaN or raised an exception."""
    stage: str
    """What the solver is at, in its words; often empty."""


class SolverEntry(NamedTuple):
    """A solver that can be named."""

    name: str
    meaning: str
    options: dict[str, tuple[str, str]]
    """(default, meaning) of each option."""


def list_solvers() -> list[SolverEntry]:
    """The solvers that `solve` knows by their names, with their options."""
    return [SolverEntry(*entry) for entry in _core._list_solvers()]


def _check_problem(problem: object, kind: type[DesignProblem] = DesignProblem) -> None:
    if isinstance(problem, kind):
        return
    hint = "; load_problem makes one of a file or an ID" if isinstance(problem, str | os.PathLike) else ""
    raise TypeError(f"problem: {problem!r} is no {kind.__name__}{hint}")


def evaluate(problem: DesignProblem, design: DesignLike) -> Evaluation:
    """Score and terms of `design`; the empty design is allowed.

    Raises ValueError (module, parameter, value, limit) for a design outside the search space, EvaluationError for what
    a problem of your own raised.
    """
    _check_problem(problem)
    return problem.evaluate(design)


class _ProgressLine:
    """Shows progress: a line that is written over in a terminal or a notebook, else a line every five seconds."""

    def __init__(self) -> None:
        self._over = sys.stderr.isatty() or "ipykernel" in sys.modules
        self._due = 0.0
        self._width = 0

    def __call__(self, progress: Progress) -> None:
        if progress.seconds < self._due:
            return
        standing = "nothing yet" if progress.score is None else f"best {progress.score:.6g}"
        if progress.score is not None and not progress.achieved:
            standing += " (not achieved)"
        failed = f", {progress.failed} failed" if progress.failed else ""
        stage = f"; {progress.stage}" if progress.stage else ""
        line = f"{progress.seconds:.1f} s, {progress.evaluations} evaluations{failed}: {standing}{stage}"
        if self._over:
            print("\r" + line.ljust(self._width), end="", file=sys.stderr, flush=True)
            self._width = len(line)
        else:
            print(line, file=sys.stderr, flush=True)
            self._due = progress.seconds + 5.0

    def close(self) -> None:
        """Leaves the line."""
        if self._over and self._width:
            print(file=sys.stderr)


def solve(
    problem: DesignProblem,
    solver: str | Solver = "auto",
    *,
    evaluations: int | None = None,
    seconds: float | None = None,
    until: Literal["achieved"] | float | None = None,
    seed: int = 0,
    refine: bool = False,
    progress: bool | Callable[[Progress], object] = False,
) -> Solution:
    """Searches for the best design of `problem`.

    `solver`: as on the command line, "ga" or "ga:population=50" or "policy:FILE" (see list_solvers), or a Solver of
    your own. `evaluations`, `seconds`: the budget; with neither the search ends when nothing more can be proved or
    improved, at the latest after 30 s. `until`: "achieved" ends it at the first design that does what was asked, a
    number at the first one of these that scores at least so much. `seed`: equal arguments give equal solutions, unless
    seconds cut in. `refine`: the lengths of the best design's modules are then solved for. `progress`: True prints how
    far it is to the standard error, a function is called with a Progress, at most five times a second.

    Other threads run meanwhile. Ctrl-C ends the search: what was found so far is returned, with `stop` "interrupted",
    and KeyboardInterrupt is raised only where no design was evaluated yet. What `progress` or a Solver of your own
    raises ends the search and is raised; what a DesignProblem of your own raises counts as a failed evaluation.

    Raises ValueError for a solver, option or budget that is none, FileError for a policy that cannot be used.
    """
    _check_problem(problem)
    if not 0 <= seed < 2**64:
        raise ValueError(f"seed: {seed} is not in [0, 2^64)")
    if until is None:
        target = math.inf
    elif until == "achieved":
        target = -math.inf
    elif isinstance(until, str):
        raise ValueError(f"until: {until!r} is neither 'achieved' nor a score")
    else:
        target = float(until)
    line = _ProgressLine() if progress is True else None
    show = line or progress
    callback = (lambda *fields: show(Progress(*fields))) if callable(show) else None
    try:
        found = _core._solve(problem, solver, evaluations, seconds, target, seed, refine, callback)
    finally:
        if line is not None:
            line.close()
    if found["bound"] is not None:
        found["bound"] = Bound(*found["bound"])
    if until == "achieved" and found["stop"] == "target score":
        found["reason"] = "the first achieved design, as asked"
    return Solution(problem=problem, seed=seed, **found)


def verify(problem: RobotProblem, design: DesignLike | Solution, *, refinement: float = 10.0) -> Verification:
    """Evaluates a design again from scratch, at the problem's level and at level path, and checks its path finer.

    Of a Solution its score and standing are held against what is found, its postures are tried first, and its path is
    the one that is checked; nothing else is taken over. `refinement`: a path is checked in steps this many times finer
    than the planner's.

    Raises ValueError for a design outside the search space, TypeError for a problem that is no RobotProblem.
    """
    _check_problem(problem, RobotProblem)
    if not isinstance(design, Solution):
        return _core._verify(problem, design, None, None, None, None, refinement)
    evaluation = design.evaluation
    return _core._verify(
        problem,
        design.design,
        evaluation.score if math.isfinite(evaluation.score) else None,
        evaluation.achieved,
        evaluation.postures if evaluation.achieved else None,
        evaluation.attempt.path,
        refinement,
    )
