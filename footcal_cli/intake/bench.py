"""Bench logs as the core takes them: rows per channel, running recordings, placements per foot."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from footcal_cli.core.bench.cop_study import FootStudy, study_cop
from footcal_cli.core.bench.matrix import MatrixStudy, study_matrix
from footcal_cli.core.bench.placement_rows import PlacementRows, condense_points, holes_of
from footcal_cli.core.bench.plateaus import PlateauOptions
from footcal_cli.core.bench.record import BenchRecord, record_of
from footcal_cli.core.bench.study import Asked, ChannelStudy, study_rows, study_samples
from footcal_cli.core.bench_rows import pieces_by_pauses
from footcal_cli.core.effects.calibration import AXES, AXIS_UNITS
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import BoolArray, FloatArray, IntArray
from footcal_cli.core.readings import find_end_codes
from footcal_cli.core.signals import goes_on
from footcal_cli.errors import UsageError, nearest
from footcal_cli.recipe import Robot
from footcal_cli.recipe.options import OfflineFitOptions, PlateauSettings
from footcal_cli.tables.columns import (
    AXIS_COLUMNS,
    cop_points_table,
    placements_table,
    weights_stream_table,
    weights_table,
    weights_together_table,
)
from footcal_cli.tables.table import Table

if TYPE_CHECKING:
    from footcal_cli.session.session import Session

FRAMES_OF_A_POINT = 50
"""With more rows than this per point they are frames of a recording, condensed to medians."""


@dataclass(frozen=True)
class WeightsLogs:
    """Everything weighed: long tables, and the records to fit and to keep apart."""

    tables: Sequence[Table]
    records: Sequence[BenchRecord]
    held_out: Sequence[BenchRecord]


def read_weights(session: Session[OfflineFitOptions]) -> WeightsLogs:
    """Long tables and running recordings; of ``[data]`` also those to keep apart."""
    channels = session.recipe.robot.cell_names
    own_data = not session.request.logs
    tables = session.read(weights_table())
    bits = session.recipe.robot.adc.bits
    records = records_of_rows(tables, bits) if tables else []
    apart = session.read(weights_table(), "weights_held_out") if own_data else []
    held_out = records_of_rows(apart, bits) if apart else []
    if channels:
        stream = weights_stream_table(channels)
        running = session.read(stream)
        records += records_of_streams(running, channels) if running else []
        apart = session.read(stream, "weights_stream_held_out") if own_data else []
        held_out += records_of_streams(apart, channels) if apart else []
    return WeightsLogs(tables, records, held_out)


def studies_of(
    records: Sequence[BenchRecord], options: OfflineFitOptions, gravity_mps2: float,
    cells: int | None = None,
) -> list[ChannelStudy]:  # fmt: skip
    """Every channel's models, of so many cells: of rows as they are, or of settled samples."""
    auto, count = options.models == "auto", len(records) if cells is None else cells
    asked = Asked(options.method, auto, options.most_degree, count)
    found, holds = [], options.plateaus
    for record in records:
        if record.recorded if options.samples is None else options.samples:
            settled, loads_n = plateau_options(holds), holds.known_n(gravity_mps2)
            found.append(study_samples(record, asked, options=settled, loads_n=loads_n))
        else:
            found.append(study_rows(record, asked))
    return found


def plateau_options(settings: PlateauSettings) -> PlateauOptions:
    """What the core takes for standing still."""
    return PlateauOptions(**settings.model_dump(exclude={"loads_n", "loads"}))


def records_of_rows(tables: Sequence[Table], bits: int) -> list[BenchRecord]:
    """Long weights logs, one record per channel; every file and session is one of its sessions.

    A converter of `bits` that is at its end code says no more than that the load is beyond it: such
    readings count as none, as long as two loads remain.
    """
    channel = np.concatenate([table.text("channel") for table in tables])
    session = sessions_of(tables, pauses=True)
    columns = {
        name: np.concatenate([table.optional(name) for table in tables])
        for name in ("load_n", "counts", "time_s", "temperature_degc", "direction")
    }
    records = []
    for name in dict.fromkeys(channel):
        at = channel == name
        known = {"load_n": columns["load_n"][at]}
        read = columns["counts"][at]
        at_end = find_end_codes(read, bits)
        if np.unique(known["load_n"][~at_end]).size > 1:
            read = np.where(at_end, np.nan, read)
        for optional in ("temperature_degc", "direction"):
            if np.isfinite(columns[optional][at]).all():
                known[optional] = columns[optional][at]
        log = Log(
            experiment="weights",
            channels=(str(name),),
            time_s=columns["time_s"][at],
            readings=read[:, None],
            known=known,
            block=session[at],
        )
        records.append(record_of(log))
    return records


def records_of_streams(tables: Sequence[Table], channels: Sequence[str]) -> list[BenchRecord]:
    """Running recordings with one column per channel; a file may go on with the one before it."""
    session = _continued(tables, sessions_of(tables, pauses=True))
    columns = {
        name: _joined([table.optional(name) for table in tables])
        for name in ("time_s", "load_n", "temperature_degc")
    }
    order, warmth = _in_order(session, columns["time_s"]), columns.pop("temperature_degc")
    return [
        BenchRecord(
            channel=channel,
            load_n=columns["load_n"][order],
            reading=_joined([table.number(f"{channel}_counts") for table in tables])[order],
            time_s=columns["time_s"][order],
            session=session[order],
            temperature_degc=warmth[order] if np.isfinite(warmth).all() else None,
        )
        for channel in channels
    ]


def _in_order(session: IntArray, time_s: FloatArray) -> IntArray | slice:
    """Rows by session and time: a slice of all where they lie so already, and nothing is copied."""
    fresh = np.diff(session)
    if np.all((fresh > 0) | ((fresh == 0) & (np.diff(time_s) >= 0))):
        return slice(None)
    return np.lexsort((time_s, session))


def _continued(tables: Sequence[Table], session: IntArray) -> IntArray:
    """Sessions (n,), one for files that a logger cut: the next sample is that of another file."""
    ends = np.cumsum([len(table) for table in tables])
    spans = []
    for table, end in zip(tables, ends, strict=True):
        time_s = table.number("time_s")
        own = np.unique(session[end - len(table) : end])
        if time_s.size > 1 and own.size == 1:
            spans.append((float(time_s.min()), int(own[0]), time_s))
    joined = session.copy()
    in_order = sorted(spans, key=lambda span: span[:2])
    for (_, earlier, before_s), (_, later, after_s) in pairwise(in_order):
        if goes_on(before_s, after_s):
            joined[session == later] = joined[session == earlier][0]
    return joined


def sessions_of(tables: Sequence[Table], *, pauses: bool = False) -> IntArray:
    """Number of the session of every row: file by file, and within a file by its session column.

    A log without one has repeats at most: each ladder is then a session. Else `pauses` of hours do.
    """
    numbers, first = [], 0
    for table in tables:
        name = "session" if "session" in table else "repeat" if "repeat" in table else None
        index = pieces_by_pauses(table.optional("time_s")) * int(pauses)
        if name is not None:
            labels: Any = table.text(name)
            index = np.unique(labels.astype(str), return_inverse=True)[1].astype(np.int64)
        numbers.append(index + first)
        first = int(numbers[-1].max()) + 1
    return np.concatenate(numbers)


def _joined(parts: Sequence[Any]) -> Any:
    """The parts of several logs as one array; a log by itself is not copied."""
    return parts[0] if len(parts) == 1 else np.concatenate(parts)


@dataclass(frozen=True)
class PlacementLog:
    """The placements of one foot.

    Parameters
    ----------
    rows
        With calibrated cell forces.
    names
        Name of the placement of every row, shape (n,).
    before
        The same rows with nominal forces, None where no nameplate scale is known.
    """

    rows: PlacementRows
    names: Any
    before: PlacementRows | None = None


def study_together(
    session: Session[OfflineFitOptions],
) -> tuple[tuple[str, ...], MatrixStudy] | None:
    """Cells loaded together: names of the known loads and the matrices; None without a log."""
    rows = rows_together(session, known_wrench=session.options.known_wrench)
    if rows is None:
        return None
    return rows.outputs, study_matrix(
        rows.channels, rows.readings, rows.outputs, rows.loads, rows.session, rows.case, rows.units
    )


@dataclass(frozen=True)
class RowsTogether:
    """Cells that were loaded together, or a sensor of c bridges under known wrenches.

    Parameters
    ----------
    channels, readings
        Names and raw readings, shape (n, c).
    outputs, units, loads
        Names, units and values of the known loads, shape (n, k).
    session, case
        Number of the session and of the load case of each row, shape (n,).
    """

    channels: tuple[str, ...]
    readings: FloatArray
    outputs: tuple[str, ...]
    units: tuple[str, ...]
    loads: FloatArray
    session: IntArray
    case: IntArray


def rows_together(session: Session[Any], *, known_wrench: bool) -> RowsTogether | None:
    """All rows of the logs of cells loaded together, or of known wrenches; None without a log."""
    channels = session.recipe.robot.cell_names
    if not channels:
        return None
    tables = session.read(weights_together_table(channels, known_wrench=known_wrench))
    if not tables:
        return None
    readings = np.concatenate([t.numbers([f"{c}_counts" for c in channels]) for t in tables])
    if known_wrench:
        outputs, units = AXES, AXIS_UNITS
        names = [f"known_{column}" for column in AXIS_COLUMNS]
    else:
        outputs, units = tuple(channels), ("N",) * len(channels)
        names = [f"{channel}_load_n" for channel in channels]
    loads = np.concatenate([table.numbers(names) for table in tables])
    if all("case" in table for table in tables):
        labels: Any = np.concatenate([table.text("case") for table in tables]).astype(str)
        _, case = np.unique(labels, return_inverse=True)
    else:
        _, case = np.unique(np.round(loads, 6), axis=0, return_inverse=True)
    return RowsTogether(
        tuple(channels), readings, outputs, units, loads, sessions_of(tables),
        case.reshape(-1).astype(np.int64),
    )  # fmt: skip


def read_feet(
    session: Session[OfflineFitOptions], calibration: dict[str, tuple[float, float]]
) -> tuple[dict[str, PlacementLog], dict[str, PlacementLog]]:
    """Placements of every foot and of an instrument, and of feet those to keep apart."""
    robot, least = session.recipe.robot, session.options.min_force_n
    logs, apart = {}, {}
    cells = next((tuple(foot.cells) for foot in robot.feet.values() if foot.cells), ())
    if cells:
        table = placements_table(cells)
        if tables := session.read(table):
            logs = read_placements(tables, robot, calibration, least)
        held = [] if session.request.logs else session.read(table, "placements_held_out")
        if held:
            apart = read_placements(held, robot, calibration, least)
    if tables := session.read(cop_points_table()):
        logs["instrument"] = read_cop_points(tables)
    return logs, apart


def read_placements(
    tables: Sequence[Table],
    robot: Robot,
    calibration: dict[str, tuple[float, float]],
    min_force_n: float,
) -> dict[str, PlacementLog]:
    """Forces and holes of every foot in the logs.

    Parameters
    ----------
    robot
        Feet with their cells' positions; the nameplate for the forces before calibration.
    calibration
        Channel -> scale (N/count) and bias (N).
    min_force_n
        Below this total force there is no CoP.

    Raises
    ------
    UsageError
        A foot the recipe does not have, or a cell without a calibration.
    """
    found: dict[str, PlacementLog] = {}
    foot_of_row = np.concatenate([table.text("foot") for table in tables])
    for foot in dict.fromkeys(foot_of_row):
        if foot not in robot.feet:
            raise UsageError(
                f"the recipe has no foot '{foot}'{nearest(str(foot), robot.feet)}",
                file=tables[0].path, column="foot", remedy="describe it under [robot.feet]",
            )  # fmt: skip
        at = foot_of_row == foot
        cells = tuple(robot.feet[foot].cells)
        channels = tuple(f"{foot}_{cell}" for cell in cells)
        missing = [channel for channel in channels if channel not in calibration]
        if missing:
            raise UsageError(
                f"placements need calibrated cells; '{missing[0]}' has no scale and bias",
                remedy="give its weights too, or an earlier calibration with --parameters",
            )
        columns = [f"{cell}_counts" for cell in cells]
        counts = np.concatenate([table.numbers(columns) for table in tables])[at]
        scale, bias = np.array([calibration[channel] for channel in channels]).T
        position = np.array([[c.x_m, c.y_m] for c in robot.feet[foot].cells.values()])
        hole = np.concatenate([table.numbers(["hole_x_m", "hole_y_m"]) for table in tables])[at]

        load = np.concatenate([table.number("load_n") for table in tables])[at]
        nominal, zero = robot.nameplate.scale_n_per_count, float(np.median(-bias / scale))
        rows = PlacementRows(
            cells=channels,
            forces_n=counts * scale + bias,
            cell_pos_m=position,
            hole_m=hole,
            load_n=load,
            placement=holes_of(hole),
            min_force_n=min_force_n,
        )
        # nameplate scale, common zero: what a foot reads before anyone calibrates it
        before = None if nominal is None else replace(rows, forces_n=nominal * (counts - zero))
        names = np.concatenate([table.text("placement") for table in tables])[at]
        found[str(foot)] = PlacementLog(rows, _named_by_place(names.astype(str), hole), before)
    return found


def _named_by_place(names: NDArray[np.str_], hole: FloatArray) -> NDArray[np.str_]:
    """Names of points (n,), by their places (n, 2) where all bear one name."""
    place = holes_of(hole)
    several = 1 < len(np.unique(place)) <= len(place) / 2
    if len(set(names.tolist())) > 1 or not several:
        return names
    return np.array([f"{1e3 * x:.1f}, {1e3 * y:.1f} mm" for x, y in hole])


def read_cop_points(tables: Sequence[Table]) -> PlacementLog:
    """Reported CoP at known points of an instrument whose cells were not logged."""
    names = np.concatenate([table.text("placement") for table in tables])
    hole = np.concatenate([table.numbers(["hole_x_m", "hole_y_m"]) for table in tables])
    cop = np.concatenate([table.numbers(["cop_x_m", "cop_y_m"]) for table in tables])
    names = _named_by_place(names.astype(str), hole)
    _, index = np.unique(names.astype(str), return_inverse=True)
    n = len(names)
    rows = PlacementRows(
        cells=(),
        forces_n=np.zeros((n, 0)),
        cell_pos_m=np.zeros((0, 2)),
        hole_m=hole,
        load_n=np.full(n, np.nan),
        placement=index.astype(np.int64),
        given_cop_m=cop,
    )
    labels = np.unique(names.astype(str))
    if n > FRAMES_OF_A_POINT * len(labels):
        rows = condense_points(rows)
    return PlacementLog(rows, labels[rows.placement])


def study_foot(foot: str, log: PlacementLog, held: BoolArray) -> FootStudy:
    """Compare the corrections on the placements that are not held out."""
    return FootStudy(
        foot=foot,
        rows=log.rows.select(~held),
        study=study_cop(log.rows.select(~held)),
        held_out=log.rows.select(held) if held.any() else None,
        before=log.before,
    )
