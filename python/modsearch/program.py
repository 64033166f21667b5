"""The programs that come with the package."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path


def program(name: str) -> str:
    """The file of a program of the package: "modsearch" or "modsearch-check". Raises FileNotFoundError."""
    file = Path(__file__).parent / "bin" / name
    if not file.exists():
        raise FileNotFoundError(f"{file}: the package was installed without its programs")
    return os.fspath(file)


def run(name: str, *arguments: str | os.PathLike[str]) -> subprocess.CompletedProcess[str]:
    """Runs a program as a child process and waits for it, with its output as text."""
    command = [program(name), *(os.fspath(argument) for argument in arguments)]
    return subprocess.run(command, capture_output=True, text=True, check=False)
