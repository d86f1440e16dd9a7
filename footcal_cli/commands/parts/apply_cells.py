"""`apply` for feet with load cells: forces and centres of pressure."""

from __future__ import annotations

import shutil
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from footcal_cli.core.bench.cop_models import corrected_cop_m
from footcal_cli.core.bench.matrix import bias_of, mixing_of
from footcal_cli.core.chain import Chain, Link, link
from footcal_cli.core.effects import calibration_of
from footcal_cli.core.effects.contract import Trait
from footcal_cli.core.effects.foot import CELL_POSITION
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.plausibility import check_total_force
from footcal_cli.errors import UsageError
from footcal_cli.intake.cell_effects import (
    temperature_assumed,
    temperature_doubt,
    temperature_range,
)
from footcal_cli.records.effects import effect_of
from footcal_cli.records.files import read_record
from footcal_cli.records.results import (
    CopCorrectionRecord,
    CopCorrectionsRecord,
    ParametersRecord,
    RmseRecord,
    VerdictRecord,
)
from footcal_cli.report import Report, Sheet, number
from footcal_cli.session.run_folder import scratch
from footcal_cli.session.session import Outcome
from footcal_cli.tables.columns import cells_table
from footcal_cli.tables.table import write_parquet_pieces

_MOST_KEPT = 2**20
"""Values from which a median is told; of longer logs every second, fourth …"""

if TYPE_CHECKING:
    from footcal_cli.commands.apply import ApplyOptions
    from footcal_cli.session.session import Session
    from footcal_cli.tables.table import Table


def _forces(
    log: Log, record: ParametersRecord, state: Mapping[int, Any] | None
) -> tuple[FloatArray, FloatArray, dict[int, Any]]:
    """Counts through the inverse of the calibration: forces (n, c), cell positions (n, c, 2).

    `state` is what the piece of the log before has left in effects with a memory.
    """
    values = {name: p.value for name, p in record.parameters.items()}
    mixing = mixing_of(values, log.channels)
    chain = Chain(())
    if mixing is None:
        chain = Chain((link(calibration_of(log.channels), log.channels),))
    else:
        log = log.with_readings(log.readings @ mixing.T + bias_of(values, log.channels))
    for item in record.effects:
        effect = effect_of(item)
        if Trait.CALIBRATION in effect.traits:
            continue
        lacking = [name for name in effect.needs if name not in log.known]
        if lacking:
            raise UsageError(
                f"the calibration contains {effect.name}, which needs {', '.join(lacking)}",
                remedy="use online-replay, which knows them",
            )
        chain = chain.with_link(Link(effect, dict(item.owners)))
    truth, left = chain.remove(log, values, state)
    return truth.readings, truth.known["cell_pos_m"], left


def _correction(
    session: Session[ApplyOptions], record: ParametersRecord
) -> dict[str, CopCorrectionRecord]:
    """Polynomials of ``cop_correction.json`` by foot; refused where cells are corrected already."""
    given = session.options.cop_correction
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


@dataclass(frozen=True)
class _Calibration:
    """What a piece of a log needs to become forces."""

    record: ParametersRecord
    cells: tuple[str, ...]
    where: FloatArray
    warmth: float | None
    corrections: dict[str, CopCorrectionRecord]
    feet: Mapping[str, list[str]]
    least_force_n: float


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
    warmth = None
    needs = [need for item in record.effects for need in effect_of(item).needs]
    if "temperature_degc" in needs:
        values = {name: p.value for name, p in record.parameters.items()}
        warmth, half = temperature_range(record)
        if "temperature_degc" not in first:
            doubt = temperature_doubt(values, cells, half)
            session.note((temperature_assumed(warmth, half, *doubt),))
    feet = {f: [f"{f}_{cell}" for cell in spec.cells] for f, spec in robot.feet.items()}
    return _Calibration(
        record, cells, np.array([places.get(cell, (np.nan, np.nan)) for cell in cells]), warmth,
        _correction(session, record),
        {f: own for f, own in feet.items() if own and all(cell in cells for cell in own)},
        session.options.least_force_n,
    )  # fmt: skip


def _applied(
    table: Table, calibration: _Calibration, state: Mapping[int, Any] | None
) -> tuple[dict[str, FloatArray], dict[int, Any]]:
    """Columns of ``calibrated.parquet`` for a piece of a log, and what the next piece needs."""
    cells, time_s = calibration.cells, table.number("time_s")
    known = {"cell_pos_m": np.tile(calibration.where, (time_s.size, 1, 1))}
    if "temperature_degc" in table:
        known["temperature_degc"] = table.number("temperature_degc")
    elif calibration.warmth is not None:
        known["temperature_degc"] = np.full(time_s.size, calibration.warmth)
    counts = table.numbers([f"{c}_counts" for c in cells])
    log = Log("walk", cells, time_s, counts, known, np.zeros(time_s.size, dtype=np.int64))
    force_n, cell_pos_m, state = _forces(log, calibration.record, state)
    columns = {"time_s": time_s} | {f"{c}_n": force_n[:, i] for i, c in enumerate(cells)}
    for foot, own_cells in calibration.feet.items():
        at = [cells.index(cell) for cell in own_cells]
        own = force_n[:, at]
        total = own.sum(axis=1)
        loaded = total > calibration.least_force_n
        moment = np.einsum("nc,nck->nk", own, cell_pos_m[:, at])
        cop = np.where(loaded[:, None], moment / np.where(loaded, total, 1.0)[:, None], np.nan)
        if foot in calibration.corrections:
            found = calibration.corrections[foot]
            both = np.column_stack([found.coefficients_x, found.coefficients_y])
            cop = corrected_cop_m(found.terms, both, cop, own, own_cells)
        columns |= {
            f"{foot}_fz_n": total,
            f"{foot}_cop_x_m": cop[:, 0],
            f"{foot}_cop_y_m": cop[:, 1],
        }
    return columns, state


class _Seen:
    """A series of which so many values are kept as its median needs; all up to `_MOST_KEPT`."""

    def __init__(self) -> None:
        self.kept = np.zeros(0)
        self.every, self.count, self.loaded, self.largest = 1, 0, 0, -np.inf

    def add(self, values: FloatArray, least: float) -> None:
        """Take in the next values; `least` is the load from which a foot counts as loaded."""
        chosen = values[(-self.count) % self.every :: self.every]
        self.kept = np.concatenate([self.kept, chosen])
        while self.kept.size > _MOST_KEPT:
            self.kept, self.every = self.kept[::2], 2 * self.every
        self.count += values.size
        self.loaded += int(np.sum(values > least))
        self.largest = max(self.largest, float(np.nanmax(values, initial=-np.inf)))

    @property
    def median(self) -> float:
        """Of all that were kept."""
        return float(np.nanmedian(self.kept))


def apply_cells(session: Session[ApplyOptions]) -> Outcome:
    """Counts to newtons by ``F = scale · S + bias``, effects of the calibration undone, and CoP."""
    robot = session.recipe.robot
    cells = robot.cell_names
    feet: dict[str, _Seen] = {}
    total, lost = _Seen(), 0
    written = scratch() / "calibrated.parquet"

    def pieces() -> Iterator[dict[str, FloatArray]]:
        nonlocal lost
        calibration, state = None, None
        for table in session.pieces(cells_table(cells)):
            calibration = calibration or _calibration(session, table)
            columns, state = _applied(table, calibration, state)
            force_n = np.column_stack([columns[f"{c}_n"] for c in cells])
            total.add(force_n.sum(axis=1), 0.0)
            lost += int((~np.isfinite(force_n).all(axis=1)).sum())
            for foot in calibration.feet:
                seen = feet.setdefault(foot, _Seen())
                seen.add(columns[f"{foot}_fz_n"], session.options.least_force_n)
            yield columns

    with session.step("apply"):
        write_parquet_pieces(pieces(), written)
    session.note(check_total_force(total.kept, robot.weight_n, "all cells"))
    rows = [
        (
            foot,
            number(seen.median, 4),
            number(seen.largest, 4),
            f"{100 * seen.loaded / seen.count:.0f}",
        )
        for foot, seen in feet.items()
    ]

    def move(path: Path) -> None:
        shutil.move(written, path)

    return Outcome(
        report=Report(
            title=f"Forces of {robot.name}",
            verdict=VerdictRecord(
                level="good",
                sentence=f"{len(cells)} cells calibrated over {total.count:,} samples; sum of all "
                f"forces {number(total.median, 4)} N (median).",
            ),
            sheets=(
                Sheet("Feet", ("foot", "median Fz (N)", "largest Fz (N)", "loaded (%)"), rows),
            ),
            footer=(
                "F = scale · S + bias per cell; CoP = Σ p F / Σ F in the foot frame, absent where "
                f"Fz ≤ {session.options.least_force_n:g} N (NAO CoP self-calibration, eqs. (1), "
                f"(2), (8)).",
            ),
        ),
        rmse=RmseRecord(rows=(), rejected={"reading is missing": lost} if lost else {}),
        files={"calibrated.parquet": move},
    )
