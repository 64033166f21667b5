"""Modular robot arms as a search problem: which modules, in which order, with which lengths.

>>> import modsearch
>>> problem = modsearch.load_problem("seed/random_obstacles", instance=(0, 3))
>>> solution = modsearch.solve(problem, "auto")
>>> modsearch.verify(problem, solution)

Lengths are in m, angles in rad, masses in kg, poses are homogeneous matrices [4, 4] in the world frame, and a score is
better the greater it is. With Gymnasium installed the environments modsearch/Design-v0, modsearch/Design-Flat-v0 and
modsearch/Design-Binned-v0 are registered.
"""

from . import pickling as _pickling  # noqa: F401
from ._core import (
    Arm,
    Attempt,
    Design,
    DesignProblem,
    Evaluation,
    EvaluationError,
    FileError,
    Goal,
    IkSolution,
    Meter,
    ModuleLibrary,
    Path,
    Rng,
    RobotProblem,
    Solver,
    Verification,
    __version__,
    convert,
    list_libraries,
    list_problems,
    load_library,
    load_problem,
    random_design,
)
from .certificates import Certificate, CertificateCheck, certify, check_certificate
from .gym import register_environments as _register_environments
from .solution import Bound, Solution, load_solution
from .solving import Progress, SolverEntry, evaluate, list_solvers, solve, verify

__all__ = [
    "Arm",
    "Attempt",
    "Bound",
    "Certificate",
    "CertificateCheck",
    "Design",
    "DesignProblem",
    "Evaluation",
    "EvaluationError",
    "FileError",
    "Goal",
    "IkSolution",
    "Meter",
    "ModuleLibrary",
    "Path",
    "Progress",
    "Rng",
    "RobotProblem",
    "Solution",
    "Solver",
    "SolverEntry",
    "Verification",
    "__version__",
    "certify",
    "check_certificate",
    "convert",
    "evaluate",
    "list_libraries",
    "list_problems",
    "list_solvers",
    "load_library",
    "load_problem",
    "load_solution",
    "random_design",
    "solve",
    "verify",
]

# To users all of this is modsearch, whatever file it is written in: so it is in messages and in pickled objects.
for _public in [globals()[_name] for _name in __all__]:
    if isinstance(_public, type):
        _public.__module__ = "modsearch"
del _public

_register_environments()
