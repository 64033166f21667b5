"""Every public name says what it is."""

import inspect

import pytest

import modsearch

PUBLIC = [name for name in modsearch.__all__ if name != "__version__"]
INHERITED = {name for kind in (object, tuple, type, ValueError, RuntimeError) for name in dir(kind)}


@pytest.mark.parametrize("name", PUBLIC)
def test_a_public_name_and_its_members_have_docstrings(name):
    thing = getattr(modsearch, name)
    assert inspect.getdoc(thing), name
    if not isinstance(thing, type):
        return
    fields = getattr(thing, "__dataclass_fields__", getattr(thing, "_fields", {}))
    for member in dir(thing):
        if member.startswith("_") or member in INHERITED or member in fields:
            continue
        assert inspect.getdoc(getattr(thing, member)), f"{name}.{member}"


def test_version_is_that_of_the_build():
    assert modsearch.__version__.count(".") == 2
