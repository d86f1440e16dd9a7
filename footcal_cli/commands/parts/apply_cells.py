"""`apply` for feet with load cells: forces and centres of pressure (seed 1, eqs. (1), (2), (8))."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from footcal_cli.columns import cells_table
from footcal_cli.core.chain import Chain, Link, link
from footcal_cli.core.effects import find_effect
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import FloatArray
from footcal_cli.errors import UsageError
from footcal_cli.records import ParametersRecord, RmseRecord, VerdictRecord
from footcal_cli.report import Report, Sheet, number
from footcal_cli.session import Outcome

if TYPE_CHECKING:
    from footcal_cli.commands.apply import ApplyOptions
    from footcal_cli.session import Session


def _removed(log: Log, record: ParametersRecord) -> FloatArray:
    """Forces (n, c): counts through the inverse of everything the calibration contains."""
    chain = Chain((link(find_effect("scale_bias"), log.channels),))
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
    truth, _ = chain.remove(log, {name: p.value for name, p in record.parameters.items()})
    return truth.readings


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
    warmth = [t.number("temperature_degc") for t in tables if "temperature_degc" in t]
    known = {"temperature_degc": np.concatenate(warmth)} if len(warmth) == len(tables) else {}
    log = Log("walk", cells, time_s, counts, known, np.zeros(time_s.size, dtype=np.int64))
    force_n = _removed(log, record)
    columns = {"time_s": time_s} | {f"{c}_n": force_n[:, i] for i, c in enumerate(cells)}
    rows = []
    for foot, spec in robot.feet.items():
        own_cells = [f"{foot}_{cell}" for cell in spec.cells]
        if not own_cells or any(cell not in cells for cell in own_cells):
            continue
        own = force_n[:, [cells.index(cell) for cell in own_cells]]
        total = own.sum(axis=1)
        loaded = total > session.options.least_force_n
        where = np.array([[cell.x_m, cell.y_m] for cell in spec.cells.values()])
        cop = np.where(loaded[:, None], own @ where / np.where(loaded, total, 1.0)[:, None], np.nan)
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
                f"Fz ≤ {session.options.least_force_n:g} N (seed 1, eqs. (1), (2), (8)).",
            ),
        ),
        rmse=RmseRecord(rows=(), rejected={"reading is missing": lost} if lost else {}),
        files={"calibrated.parquet": write},
    )
