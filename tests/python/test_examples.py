"""The examples run and print what they promise."""

import pathlib
import re
import subprocess
import sys

import pytest

EXAMPLES = pathlib.Path(__file__).parents[2] / "examples" / "python"


def run(name: str, *words: str) -> str:
    done = subprocess.run(
        [sys.executable, str(EXAMPLES / name), *words], capture_output=True, text=True, check=False, timeout=120
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_first_design(tmp_path):
    said = run("first_design.py", str(tmp_path))
    assert "by hand: Evaluation(" in said
    assert "Verification(verified, level=path)" in said
    assert (tmp_path / "solution.json").exists()
    assert (tmp_path / "view.html").read_text().startswith("<!")


def test_gym_random_agent():
    pytest.importorskip("gymnasium")
    said = run("gym_random_agent.py")
    assert re.search(r"one at a time: \d+ of 100 targets reached, mean return -?[\d.]+\n", said)
    assert re.search(r"64 at a time: [1-9]\d* episodes in 6400 steps", said)
