"""How loops are compiled: by numba (``pip install 'footcal[fast]'``).

Imported only where numba is at hand. Machine code is kept beside the sources or in the user's
cache, so that only the first run compiles. It is found by the line on which a function begins, and
its types are unpickled before it is asked whether it is stale: whoever renames a tuple that a loop
takes moves the loops by a line.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar, cast

from numba import njit

_REORDER = {"reassoc", "contract", "arcp", "nsz"}
"""Sums may be added in another order; NaN and infinity keep their meaning."""

Function = TypeVar("Function", bound=Callable[..., Any])


def compiled(function: Function) -> Function:
    """Compile a function of arrays and numbers when it is first called."""
    return cast("Function", njit(cache=True, fastmath=_REORDER)(function))
