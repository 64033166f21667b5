"""Types for those who check theirs."""

from __future__ import annotations

import os
from collections.abc import Iterable
from typing import TYPE_CHECKING, TypeAlias, Union

from numpy.typing import ArrayLike

if TYPE_CHECKING:
    from ._core import Design, DesignProblem, ModuleLibrary

DesignLike: TypeAlias = Union["Design", Iterable[str | tuple[str, ArrayLike]]]
"""What stands for a design: a Design, or (type, parameters) for each module, base to tip."""

LibraryLike: TypeAlias = Union["ModuleLibrary", "DesignProblem", str, "os.PathLike[str]"]
"""What stands for a library: itself, a problem, or an ID or file."""
