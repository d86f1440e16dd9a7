"""Feet that report a vertical force and a CoP: three cells that stand in for a plate.

Force and CoP are as much as three vertical forces at known places: ``Σ f = F`` and
``Σ p f = F · CoP``. With the cells in place of the plate, standing and walking are calibrated as
on cells.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from footcal_cli.core.parameters import FloatArray
from footcal_cli.tables.canonical import ReadColumn
from footcal_cli.tables.columns import Column, TableType

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True)
class Plate:
    """A foot that reports force and CoP.

    Parameters
    ----------
    foot
        Its name.
    cells
        Places (x, y) of its three cells in m, in the frame of the CoP, by name.
    """

    foot: str
    cells: Mapping[str, tuple[float, float]]

    @property
    def readings(self) -> tuple[str, ...]:
        """Columns of the cells."""
        return tuple(f"{self.foot}_{cell}_counts" for cell in self.cells)

    @property
    def columns(self) -> tuple[str, str, str]:
        """Columns of the log: force, and CoP along x and y."""
        return f"{self.foot}_fz_n", f"{self.foot}_cop_x_m", f"{self.foot}_cop_y_m"


def with_plates(table: TableType, plates: Sequence[Plate]) -> TableType:
    """A kind of log with force and CoP in place of the cells of plates."""
    stands_in = {name for plate in plates for name in plate.readings}
    if not stands_in & {column.name for column in table.columns}:
        return table
    kept = [column for column in table.columns if column.name not in stands_in]
    for plate in plates:
        meanings = ("vertical force of", "CoP, forward, of", "CoP, left, of")
        kept += [
            Column(name, f"{meaning} foot {plate.foot}", missing="keep")
            for name, meaning in zip(plate.columns, meanings, strict=True)
        ]
    return replace(table, columns=tuple(kept))


def cells_of(force_n: FloatArray, cop_m: FloatArray, places_m: FloatArray) -> FloatArray:
    """Forces of three cells, shape (n, 3): ``f = A⁻¹ [F, F x, F y]``.

    A foot in the air has no CoP: what it reads is spread evenly.

    Parameters
    ----------
    force_n, cop_m
        Shapes (n,) and (n, 2).
    places_m
        Shape (3, 2).
    """
    middle = places_m.mean(axis=0)
    cop = np.where(np.isfinite(cop_m), cop_m, middle)
    demanded = np.column_stack([force_n, force_n * cop[:, 0], force_n * cop[:, 1]])
    return np.linalg.solve(np.vstack([np.ones(3), places_m.T]), demanded.T).T


def add_cells(
    frame: pd.DataFrame, plates: Sequence[Plate]
) -> tuple[pd.DataFrame, list[ReadColumn]]:
    """A log with the readings of the cells that stand in for its plates, in N."""
    read = []
    for plate in plates:
        if not set(plate.columns) <= set(frame.columns):
            continue
        values = frame[list(plate.columns)].to_numpy(dtype=np.float64)
        found = cells_of(values[:, 0], values[:, 1:], np.array(list(plate.cells.values())))
        frame = frame.assign(**dict(zip(plate.readings, found.T, strict=True)))
        for name, column in zip(plate.readings, found.T, strict=True):
            span = (float(np.nanmin(column)), float(np.nanmax(column)))
            source = f"{plate.foot}: force and CoP"
            read.append(ReadColumn(name, source, "newton", "N", None, span, span))
    return frame, read
