"""A calibration of load cells applied to a log, piece by piece: forces and centres of pressure."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from footcal_cli.core.bench.cop_models import corrected_cop_m
from footcal_cli.core.bench.matrix import bias_of, mixing_of
from footcal_cli.core.centroidal import pressure
from footcal_cli.core.chain import Chain, Link, link
from footcal_cli.core.effects import calibration_of
from footcal_cli.core.effects.contract import Trait
from footcal_cli.core.effects.foot import CELL_POSITION
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.signals import ThinnedSeries
from footcal_cli.errors import UsageError
from footcal_cli.intake.cell_effects import (
    temperature_assumed,
    temperature_doubt,
    temperature_range,
)
from footcal_cli.records.effects import effect_of
from footcal_cli.records.files import read_record
from footcal_cli.records.results import CopCorrectionRecord, CopCorrectionsRecord, ParametersRecord
from footcal_cli.tables.columns import cells_table

if TYPE_CHECKING:
    from footcal_cli.recipe.options import ApplyOptions
    from footcal_cli.session.session import Session
    from footcal_cli.tables.table import Table


_SHOWN_S, _SHOWN_ROWS = 20.0, 20_000
"""So much of a log is kept for its figures, or so many rows."""


class SeenForces:
    """What passed through: the sum of all forces, the load of each foot, rows without a reading.

    `shown` holds the first seconds of every column, `places_m` the cells of each foot.
    """

    def __init__(self) -> None:
        self.total = ThinnedSeries(0.0)
        self.feet: dict[str, ThinnedSeries] = {}
        self.lost = 0
        self.shown: dict[str, FloatArray] = {}
        self.places_m: dict[str, FloatArray] = {}

    def forces(self, session: Session[ApplyOptions]) -> Iterator[dict[str, FloatArray]]:
        """Columns of ``calibrated.parquet``, piece by piece of the session's log."""
        calibration, state = None, None
        for table in session.pieces(cells_table(session.recipe.robot.cell_names)):
            calibration = calibration or _calibration(session, table)
            columns, state = calibration.applied(table, state)
            force_n = np.column_stack([columns[f"{c}_n"] for c in calibration.cells])
            self.total.add(force_n.sum(axis=1))
            self.lost += int((~np.isfinite(force_n).all(axis=1)).sum())
            if not self.shown:
                time_s = columns["time_s"]
                rows = slice(min(int(np.sum(time_s <= time_s[0] + _SHOWN_S)), _SHOWN_ROWS))
                self.shown = {name: values[rows] for name, values in columns.items()}
                self.places_m = calibration.places_m()
            for foot in calibration.feet:
                seen = self.feet.setdefault(foot, ThinnedSeries(calibration.min_force_n))
                seen.add(columns[f"{foot}_fz_n"])
            yield columns


@dataclass(frozen=True)
class _Calibration:
    """What a piece of a log needs to become forces.

    Parameters
    ----------
    chain, values
        The inverse of the calibration, behind the `mixing` of cells that were loaded together.
    where
        Positions of the cells in their feet, shape (c, 2).
    warmth
        Temperature where the log has none, None where nobody asks for it.
    """

    chain: Chain
    values: Mapping[str, float]
    cells: tuple[str, ...]
    mixing: FloatArray | None
    where: FloatArray
    warmth: float | None
    corrections: Mapping[str, CopCorrectionRecord]
    feet: Mapping[str, list[str]]
    min_force_n: float

    def places_m(self) -> dict[str, FloatArray]:
        """Where the cells of each foot lie, shape (c, 2)."""
        return {
            foot: self.where[[self.cells.index(cell) for cell in own]]
            for foot, own in self.feet.items()
        }

    def applied(
        self, table: Table, state: Mapping[int, Any] | None
    ) -> tuple[dict[str, FloatArray], dict[int, Any]]:
        """Columns of a piece, and what the next piece needs of effects with a memory."""
        cells, time_s = self.cells, table.number("time_s")
        known = {"cell_pos_m": np.tile(self.where, (time_s.size, 1, 1))}
        if "temperature_degc" in table:
            known["temperature_degc"] = table.number("temperature_degc")
        elif self.warmth is not None:
            known["temperature_degc"] = np.full(time_s.size, self.warmth)
        readings = table.numbers([f"{c}_counts" for c in cells])
        if self.mixing is not None:
            readings = readings @ self.mixing.T + bias_of(self.values, cells)
        log = Log("walk", cells, time_s, readings, known, np.zeros(time_s.size, dtype=np.int64))
        truth, left = self.chain.remove(log, self.values, state)
        force_n, cell_pos_m = truth.readings, truth.known["cell_pos_m"]
        columns = {"time_s": time_s} | {f"{c}_n": force_n[:, i] for i, c in enumerate(cells)}
        for foot, own_cells in self.feet.items():
            at = [cells.index(cell) for cell in own_cells]
            own = force_n[:, at]
            found = pressure(own, cell_pos_m[:, at], self.min_force_n)
            cop = found.cop_m
            if foot in self.corrections:
                fitted = self.corrections[foot]
                both = np.column_stack([fitted.coefficients_x, fitted.coefficients_y])
                cop = corrected_cop_m(fitted.terms, both, cop, own, own_cells)
            columns |= {
                f"{foot}_fz_n": found.fz_n,
                f"{foot}_cop_x_m": cop[:, 0],
                f"{foot}_cop_y_m": cop[:, 1],
            }
        return columns, left


def _calibration(session: Session[ApplyOptions], first: Table) -> _Calibration:
    """Where the cells lie, and what else the calibration contains."""
    record, robot = session.parameters, session.recipe.robot
    assert record is not None, "checked by the caller"
    cells = robot.cell_names
    for cell in cells:
        record.value(f"{cell}.scale")
    places = {
        f"{foot}_{cell}": (at.x_m, at.y_m)
        for foot, spec in robot.feet.items()
        for cell, at in spec.cells.items()
    }
    values = record.values
    mixing = mixing_of(values, cells)
    chain = Chain(()) if mixing is not None else Chain((link(calibration_of(cells), cells),))
    needs: set[str] = set()
    for item in record.effects:
        effect = effect_of(item)
        needs |= set(effect.needs)
        if Trait.CALIBRATION in effect.traits:
            continue
        lacking = [n for n in effect.needs if n not in ("cell_pos_m", "temperature_degc")]
        if lacking:
            raise UsageError(
                f"the calibration contains {effect.name}, which needs {', '.join(lacking)}",
                remedy="use online-replay, which knows them",
            )
        chain = chain.with_link(Link(effect, dict(item.owners)))
    warmth = None
    if "temperature_degc" in needs:
        warmth, half = temperature_range(record)
        if "temperature_degc" not in first:
            doubt = temperature_doubt(values, cells, half)
            session.note((temperature_assumed(warmth, half, *doubt),))
    feet = {f: [f"{f}_{cell}" for cell in spec.cells] for f, spec in robot.feet.items()}
    return _Calibration(
        chain, values, cells, mixing,
        np.array([places.get(cell, (np.nan, np.nan)) for cell in cells]), warmth,
        _corrections(session.options.cop_correction, record),
        {f: own for f, own in feet.items() if own and all(cell in cells for cell in own)},
        session.options.min_force_n,
    )  # fmt: skip


def _corrections(given: str | None, record: ParametersRecord) -> dict[str, CopCorrectionRecord]:
    """Polynomials of ``cop_correction.json`` by foot; refused where cells are corrected already."""
    if given is None:
        return {}
    feet = read_record(CopCorrectionsRecord, Path(given)).feet
    moved = [item for item in record.effects if item.effect == CELL_POSITION.name]
    for foot in feet:
        if any(owner.startswith(f"{foot}_") for item in moved for owner in item.owners):
            raise UsageError(
                f"the calibration moves the cells of foot '{foot}', which corrects its CoP already",
                file=given,
                remedy="leave out --cop-correction",
            )
    return feet
