"""Variables as a MATLAB file."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from scipy.io import savemat


def write_mat(content: Mapping[str, object], path: Path) -> None:
    """Write variables as MATLAB 5, names of any length up to 63."""
    savemat(str(path), dict(content), appendmat=False, long_field_names=True)
