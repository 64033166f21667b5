"""What a search gives back."""

from __future__ import annotations

import html
import os
import shlex
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from . import _core
from ._core import Design, DesignProblem, Evaluation, RobotProblem


class Bound(NamedTuple):
    """An upper bound on the score of every achieved design, and how it is known."""

    score: float
    reason: str


@dataclass(frozen=True, eq=False)
class Solution:
    """The best design that a search found, and what it took."""

    design: Design
    """The best one (standing, then score); empty if nothing was evaluated."""
    evaluation: Evaluation
    """Of `design`; score -inf if nothing was evaluated."""
    problem: DesignProblem | None = field(repr=False)
    """What was searched; None in a copy that was pickled without it (a problem of your own, or one built in memory)."""
    nearest: tuple[Design, Evaluation] | None = None
    """Where `design` is not achieved: the one that came nearest."""
    stop: str = "exhausted"
    """Why the search ended: 'evaluations', 'seconds', 'target score', 'interrupted', 'optimal' or 'unreachable' (both
    proved), 'exhausted'; empty where the solution was loaded from a file."""
    reason: str = ""
    """The same in words, where there is something to say."""
    bound: Bound | None = None
    """What no achieved design can exceed, where that is known."""
    tallies: dict[str, float] = field(default_factory=dict)
    """What the solver counted."""
    evaluations: int = 0
    """Evaluations of the score."""
    failed: int = 0
    """Of these, how many gave NaN or raised an exception."""
    first_failure: str = ""
    """What the first of these had to say."""
    program_evaluations: int = 0
    """Evaluations of smooth programs: inner work."""
    outcomes: dict[str, int] = field(default_factory=dict)
    """Evaluations by what became of them: 'achieved', 'unreachable', 'obstacle', .."""
    seconds: float = 0.0
    """Wall clock [s]."""
    trace: NDArray[np.float64] = field(default_factory=lambda: np.zeros((0, 4)))
    """Every improvement [n, 4]: evaluations, seconds, score, 1 where achieved."""
    solver: str = ""
    """Name of the solver."""
    options: dict[str, str] = field(default_factory=dict)
    """Its options, as given."""
    seed: int = 0
    verified: str = "none"
    """What the file says that it was loaded from: 'none', 'posture' or 'path'."""

    @property
    def score(self) -> float:
        """evaluation.score"""
        return self.evaluation.score

    @property
    def achieved(self) -> bool:
        """The design does what was asked."""
        return self.evaluation.achieved

    @property
    def postures(self) -> NDArray[np.float64]:
        """Joint positions at the goals [n_goals, n_joints], rad or m."""
        return self.evaluation.postures

    def __bool__(self) -> bool:
        return self.achieved

    def __repr__(self) -> str:
        standing = "achieved" if self.achieved else f"not achieved: {self.evaluation.why}"
        design = repr(self.design) if self.problem is None else self.problem.library.describe(self.design)
        ended = f", ended: {self.stop}" if self.stop else ""
        return (
            f"<Solution {design}, score {self.score:.6f}, {standing}; "
            f"{self.solver}: {self.evaluations} evaluations, {self.seconds:.3g} s{ended}>"
        )

    def to_json(self, folder: str | os.PathLike[str] = ".") -> str:
        """The solution as the text of a solution file that is to lie in `folder`.

        Raises ValueError for a problem that was not loaded from a file or by its ID.
        """
        problem, reference = self._loaded_problem()
        if reference not in _core.list_problems():
            reference = os.path.relpath(reference, os.fspath(folder))
        return _core._solution_json(problem, reference, self.design, self.evaluation, self._facts())

    def save(self, file: str | os.PathLike[str]) -> None:
        """Writes a solution file, whole or not at all: for load_solution and `modsearch verify`. Raises FileError."""
        file = os.fspath(file)
        _core._write_file(file, self.to_json(os.path.dirname(os.path.abspath(file))))

    def with_path(self) -> Solution:
        """The solution with a motion from home through all goals, planned now; itself where none is found."""
        problem = self._robot_problem()
        verification = _core._verify(problem, self.design, None, None, self.postures, None, 1.0)
        evaluation = _core._with_path(self.evaluation, verification)
        return replace(self, evaluation=evaluation, verified=verification.level)

    def to_html(self) -> str:
        """A page of its own, without any other file: the arm, the obstacles, the motion if there is a path, in 3-D.

        Of a design that is not achieved the one that came nearest is shown, and what it misses. Raises ValueError for
        a problem that is no RobotProblem.
        """
        problem = self._robot_problem()
        design, evaluation = self.design, self.evaluation
        if self.nearest is not None:
            design = self.nearest[0]
            evaluation = problem.evaluate(design, postures=self.nearest[1].postures)
        return _core._solution_page(problem, design, evaluation, self._facts())

    def _repr_html_(self) -> str | None:
        """What a notebook shows."""
        if not isinstance(self.problem, RobotProblem):
            return None
        page = html.escape(self.to_html(), quote=True)
        return f'<iframe srcdoc="{page}" style="width: 100%; height: 600px; border: none"></iframe>'

    def _robot_problem(self) -> RobotProblem:
        if not isinstance(self.problem, RobotProblem):
            raise ValueError("the solution's problem is no robot problem: there is no arm to show")
        return self.problem

    def _loaded_problem(self) -> tuple[RobotProblem, str]:
        problem = self._robot_problem()
        if problem.reference is None:
            raise ValueError("the solution's problem has neither a file nor an ID that a solution file could name")
        return problem, problem.reference

    def _command(self) -> str:
        problem = self._robot_problem()
        if problem.reference is None:
            return ""
        words = ["modsearch", "solve", problem.reference]
        if problem.instance is not None:
            words += ["--instance", "{}:{}".format(*problem.instance)]
        options = {key: value for key, value in self.options.items() if key != "refine"}
        text = ",".join(f"{key}={value}" for key, value in options.items())
        if self.solver == "policy":
            text = options.get("file", "")
        words += ["--solver", self.solver + (":" + text if text else "")]
        if "refine" in self.options:
            words.append("--refine")
        return shlex.join(words + ["--seed", str(self.seed), "--evaluations", str(self.evaluations)])

    def _facts(self) -> dict[str, Any]:
        return {
            "verified": self.verified,
            "solver": self.solver,
            "options": self.options,
            "seed": self.seed,
            "evaluations": self.evaluations,
            "seconds": self.seconds,
            "trace": self.trace,
            "command": self._command(),
        }

    def __getstate__(self) -> dict[str, Any]:
        state = dict(self.__dict__)
        if getattr(self.problem, "reference", None) is None:
            state["problem"] = None  # there is no name by which it could be found again
        return state

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)


def load_solution(file: str | os.PathLike[str], problem: str | os.PathLike[str] | None = None) -> Solution:
    """Reads a solution file: claims, to be verified, and the problem that they are about.

    `problem`: instead of the one that the file names. Raises FileError.
    """
    file = os.fspath(file)
    named = None if problem is None else os.fspath(problem)
    found = _core._load_solution(file, named)
    reference = found.pop("problem_reference") if named is None else named
    if named is None and reference not in _core.list_problems():
        reference = os.path.normpath(os.path.join(os.path.dirname(file), reference))
    instance = found.pop("instance")
    loaded = _core.load_problem(reference, instance)
    if not found.pop("claims"):
        found["evaluation"] = loaded.evaluate(found["design"])
    return Solution(problem=loaded, stop="", **found)
