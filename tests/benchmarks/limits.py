"""The C limits of `limits.c`, compiled when they are asked for."""

from __future__ import annotations

import ctypes
import shutil
import subprocess
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

SOURCE = Path(__file__).with_name("limits.c")
FLAGS = ("-O3", "-march=native", "-ffast-math", "-shared", "-fPIC")


def compiler() -> str | None:
    """Version line of the C compiler, None without one."""
    found = shutil.which("cc")
    if found is None:
        return None
    said = subprocess.run([found, "--version"], capture_output=True, text=True, check=True)
    return said.stdout.splitlines()[0]


def load() -> ctypes.CDLL:
    """The compiled limits."""
    folder = Path(tempfile.mkdtemp(prefix="footcal-limits-"))
    library = folder / "limits.so"
    subprocess.run(["cc", *FLAGS, str(SOURCE), "-o", str(library), "-lm"], check=True)
    return ctypes.CDLL(str(library))


def pointer(array: np.ndarray[Any, Any]) -> ctypes.c_void_p:
    """Where a contiguous array lies; keeps it alive."""
    assert array.flags.c_contiguous
    return array.ctypes.data_as(ctypes.c_void_p)


def real(value: float) -> ctypes.c_double:
    """A double as C takes it."""
    return ctypes.c_double(value)


def whole(value: int) -> ctypes.c_long:
    """A long as C takes it."""
    return ctypes.c_long(value)
