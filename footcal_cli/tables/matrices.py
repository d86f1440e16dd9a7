"""Rotation matrices in a table, row by row, as quaternions.

Room: tables; asked by table.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.spatial import nearest_rotations, quaternions_of
from footcal_cli.errors import DataError
from footcal_cli.tables.columns import NINE

if TYPE_CHECKING:
    import pandas as pd


def rotations_of_columns(frame: pd.DataFrame, stem: str, path: Path) -> FloatArray:
    """Rotations (n, 3, 3) of ``<stem>_r11`` … ``<stem>_r33``; NaN where a number is missing.

    Raises
    ------
    DataError
        A matrix that is no rotation.
    """
    numbers = frame[[f"{stem}_r{n}" for n in NINE]].to_numpy(dtype=np.float64)
    rotations = nearest_rotations(numbers.reshape(-1, 3, 3))
    bad = np.isnan(rotations).any(axis=(1, 2)) & np.isfinite(numbers).all(axis=1)
    if bad.any():
        raise DataError(
            f"{stem}_r11 … {stem}_r33 are no rotation matrix", file=path,
            row=f"row {int(np.argmax(bad)) + 1} of the data",
            remedy=f"check their order: row by row, {stem.rpartition('_')[2]} to world",
        )  # fmt: skip
    return rotations


def with_feet_turned(frame: pd.DataFrame, path: Path) -> pd.DataFrame:
    """A table with a quaternion for each foot whose orientation is logged as a matrix.

    Raises
    ------
    DataError
        A matrix that is no rotation.
    """
    names = [str(name) for name in frame.columns]
    for stem in [name.removesuffix("_r11") for name in names if name.endswith("_foot_r11")]:
        if f"{stem}_qw" not in names:
            four = quaternions_of(rotations_of_columns(frame, stem, path))
            made = {f"{stem}_q{axis}": own for axis, own in zip("xyzw", four.T, strict=True)}
            frame = frame.assign(**made)
    return frame
