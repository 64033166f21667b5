"""docs/python.md: every program in it runs, and prints what stands below it."""

import contextlib
import io
import pathlib
import re

import pytest

PAGE = pathlib.Path(__file__).parents[2] / "docs" / "python.md"


def untimed(text: str) -> str:
    return re.sub(r"\d[\d.e-]* s\b", "T s", text).strip()


def test_the_page_prints_what_it_says():
    pytest.importorskip("gymnasium")
    programs = re.findall(r"```python\n(.*?)```\n```\n(.*?)```", PAGE.read_text(), re.DOTALL)
    assert len(programs) >= 5
    names: dict[str, object] = {}  # each goes on where the one before it ended
    for program, said in programs:
        out = io.StringIO()
        with contextlib.redirect_stdout(out):
            exec(program, names)
        assert untimed(out.getvalue()) == untimed(said)
