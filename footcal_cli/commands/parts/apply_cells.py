"""`apply` for feet with load cells: forces and centres of pressure."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from footcal_cli.cell_effects import temperature_assumed, temperature_doubt, temperature_range
from footcal_cli.columns import cells_table
from footcal_cli.core.bench.cop_models import corrected_cop_m
from footcal_cli.core.bench.matrix import bias_of, mixing_of
from footcal_cli.core.chain import Chain, Link, link
from footcal_cli.core.effects import find_effect
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.plausibility import check_total_force
from footcal_cli.errors import UsageError
from footcal_cli.records.files import read_record
from footcal_cli.records.results import (
    CopCorrectionRecord,
    CopCorrectionsRecord,
    ParametersRecord,
    RmseRecord,
    VerdictRecord,
)
from footcal_cli.report import Report, Sheet, number
from footcal_cli.session import Outcome

if TYPE_CHECKING:
    from footcal_cli.commands.apply import ApplyOptions
    from footcal_cli.session import Session


def _forces(log: Log, record: ParametersRecord) -> tuple[FloatArray, FloatArray]:
    """Counts through the inverse of the calibration: forces (n, c), cell positions (n, c, 2)."""
    values = {name: p.value for name, p in record.parameters.items()}
    mixing = mixing_of(values, log.channels)
    chain = Chain(())
    if mixing is None:
        chain = Chain((link(find_effect("scale_bias"), log.channels),))
    else:
        log = log.with_readings(log.readings @ mixing.T + bias_of(values, log.channels))
    for item in record.effects:
        effect = find_effect(item.effect)
        if effect.name == "scale_bias":
            continue
        lacking = [name for name in effect.needs if name not in log.known]
        if lacking:
            raise UsageError(
                f"the calibration contains {effect.name}, which needs {', '.join(lacking)}",
                remedy="use online-replay, which knows them",
            )
        chain = chain.with_link(Link(effect, dict(item.owners)))
    truth, _ = chain.remove(log, values)
    return truth.readings, truth.known["cell_pos_m"]


def _correction(
    session: Session[ApplyOptions], record: ParametersRecord
) -> dict[str, CopCorrectionRecord]:
    """Polynomials of ``cop_correction.json`` by foot; refused where cells are corrected already."""
    given = session.options.cop_correction
    if given is None:
        return {}
    feet = read_record(CopCorrectionsRecord, Path(given)).feet
    moved = [item for item in record.effects if item.effect == "cell_position"]
    for foot in feet:
        if any(owner.startswith(f"{foot}_") for item in moved for owner in item.owners):
            raise UsageError(
                f"the calibration moves the cells of foot '{foot}', which corrects its CoP already",
                file=given,
                remedy="leave out --cop-correction",
            )
    return feet


def apply_cells(session: Session[ApplyOptions]) -> Outcome:
    """Counts to newtons by ``F = scale · S + bias``, effects of the calibration undone, and CoP."""
    record, robot = session.parameters, session.recipe.robot
    assert record is not None, "checked by the caller"
    cells = robot.cell_names
    with session.step("read"):
        tables = session.read_required(cells_table(cells))
    time_s = np.concatenate([table.number("time_s") for table in tables])
    counts = np.concatenate([table.numbers([f"{c}_counts" for c in cells]) for table in tables])
    for cell in cells:
        record.value(f"{cell}.scale")
    corrections = _correction(session, record)
    warmth = [t.number("temperature_degc") for t in tables if "temperature_degc" in t]
    places = {
        f"{foot}_{cell}": (at.x_m, at.y_m)
        for foot, spec in robot.feet.items()
        for cell, at in spec.cells.items()
    }
    where = np.array([places.get(cell, (np.nan, np.nan)) for cell in cells])
    known = {"cell_pos_m": np.tile(where, (time_s.size, 1, 1))}
    if len(warmth) == len(tables):
        known["temperature_degc"] = np.concatenate(warmth)
    elif any("temperature_degc" in find_effect(item.effect).needs for item in record.effects):
        values = {name: p.value for name, p in record.parameters.items()}
        middle, half = temperature_range(record)
        doubt = temperature_doubt(values, cells, half)
        session.note((temperature_assumed(middle, half, *doubt),))
        known["temperature_degc"] = np.full(time_s.size, middle)
    log = Log("walk", cells, time_s, counts, known, np.zeros(time_s.size, dtype=np.int64))
    force_n, cell_pos_m = _forces(log, record)
    session.note(check_total_force(force_n.sum(axis=1), robot.weight_n, "all cells"))
    columns = {"time_s": time_s} | {f"{c}_n": force_n[:, i] for i, c in enumerate(cells)}
    rows = []
    for foot, spec in robot.feet.items():
        own_cells = [f"{foot}_{cell}" for cell in spec.cells]
        if not own_cells or any(cell not in cells for cell in own_cells):
            continue
        at = [cells.index(cell) for cell in own_cells]
        own = force_n[:, at]
        total = own.sum(axis=1)
        loaded = total > session.options.least_force_n
        moment = np.einsum("nc,nck->nk", own, cell_pos_m[:, at])
        cop = np.where(loaded[:, None], moment / np.where(loaded, total, 1.0)[:, None], np.nan)
        if foot in corrections:
            found = corrections[foot]
            both = np.column_stack([found.coefficients_x, found.coefficients_y])
            cop = corrected_cop_m(found.terms, both, cop, own, own_cells)
        columns |= {
            f"{foot}_fz_n": total,
            f"{foot}_cop_x_m": cop[:, 0],
            f"{foot}_cop_y_m": cop[:, 1],
        }
        rows.append(
            (
                foot,
                number(float(np.nanmedian(total)), 4),
                number(float(np.nanmax(total)), 4),
                f"{100 * float(loaded.mean()):.0f}",
            )
        )

    def write(path: Path) -> None:
        import pandas as pd

        from footcal_cli.tables import write_parquet

        write_parquet(pd.DataFrame(columns), path)

    lost = int((~np.isfinite(force_n).all(axis=1)).sum())
    return Outcome(
        report=Report(
            title=f"Forces of {robot.name}",
            verdict=VerdictRecord(
                level="good",
                sentence=f"{len(cells)} cells calibrated over {time_s.size:,} samples; sum of all "
                f"forces {number(float(np.nanmedian(force_n.sum(axis=1))), 4)} N (median).",
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
        files={"calibrated.parquet": write},
    )
