"""Proofs of how much better another design can be, and their independent check."""

from __future__ import annotations

import json
import os
from dataclasses import dataclass

from ._core import FileError, RobotProblem
from .program import run


@dataclass(frozen=True)
class Certificate:
    """What `certify` proved. True where the gap that was asked for is closed."""

    proved: bool
    closed: bool
    """To the gap that was asked for."""
    upper: float | None
    """No achieved design scores more; None: nothing is proved, or that none is achieved."""
    lower: float | None
    """The score of a design that reaches and is free of obstacles."""
    gap: float | None
    """(upper - lower) as a share of the mass of that design."""
    unreachable: bool
    """Proved: no design is achieved."""
    open: str
    """What is left open, in words."""
    not_proved: str
    """What the proof says nothing about."""
    seconds: float
    file: str | None
    """Where the certificate lies; None: there is none."""

    def __bool__(self) -> bool:
        return self.proved and self.closed


@dataclass(frozen=True)
class CertificateCheck:
    """What modsearch-check says of a certificate. True where it is accepted."""

    accepted: bool
    words: str

    def __bool__(self) -> bool:
        return self.accepted


def certify(
    problem: RobotProblem,
    file: str | os.PathLike[str] = "certificate.json",
    *,
    gap: float = 1e-4,
    seconds: float = 120.0,
    fewer: int | None = None,
) -> Certificate:
    """Finds the best design of `problem`, proves how much better another can be, and writes the proof to `file`.

    Done by the program `modsearch` as a child process. `gap`: share of the mass that may be left open, in (0, 1].
    `seconds`: at most this long. `fewer`: prove instead that no design of at most so many modules (without the base)
    is achieved.

    Raises ValueError for a problem that was not loaded or of which nothing can be proved, FileError where the file
    cannot be written.
    """
    if getattr(problem, "reference", None) is None:
        raise ValueError("certify: the problem has neither a file nor an ID that a certificate could name")
    words = ["certify", problem.reference, "--gap", repr(gap), "--seconds", repr(seconds), "--out", os.fspath(file)]
    if problem.instance is not None:
        words += ["--instance", "{}:{}".format(*problem.instance)]
    if fewer is not None:
        words += ["--fewer", str(fewer)]
    done = run("modsearch", *words, "--json")
    if not done.stdout:
        complaint = done.stderr.strip().removeprefix("modsearch: ")
        writable = os.access(os.path.dirname(os.path.abspath(file)), os.W_OK)
        raise (ValueError if writable else FileError)(complaint)
    said = json.loads(done.stdout)
    return Certificate(
        proved=said["proved"],
        closed=said["closed"],
        upper=said.get("upper"),
        lower=said.get("lower"),
        gap=said.get("gap"),
        unreachable=said.get("unreachable", False),
        open=said["open"],
        not_proved=said["notProved"],
        seconds=said["seconds"],
        file=said.get("file"),
    )


def check_certificate(file: str | os.PathLike[str]) -> CertificateCheck:
    """Has a certificate checked by `modsearch-check`, a program that shares no code with the search.

    Raises FileError for a file that is no certificate.
    """
    done = run("modsearch-check", file)
    if done.returncode == 2:
        raise FileError(done.stderr.strip().removeprefix("modsearch-check: "))
    return CertificateCheck(accepted=done.returncode == 0, words=done.stdout.strip())
