"""Bench logs as the core takes them: rows per channel, running recordings, placements per foot."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from footcal_cli.core.bench.matrix import MatrixStudy, study_matrix
from footcal_cli.core.bench.plateaus import PlateauOptions
from footcal_cli.core.bench.record import BenchRecord, record_of
from footcal_cli.core.bench.study import Asked, ChannelStudy, study_rows, study_samples
from footcal_cli.core.bench_rows import pieces_by_pauses
from footcal_cli.core.effects.calibration import AXES, AXIS_UNITS
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import FloatArray, IntArray
from footcal_cli.core.readings import find_end_codes
from footcal_cli.core.signals import goes_on
from footcal_cli.recipe.options import OfflineFitOptions, PlateauSettings
from footcal_cli.tables.columns import (
    AXIS_COLUMNS,
    weights_stream_table,
    weights_table,
    weights_together_table,
)
from footcal_cli.tables.table import Table

if TYPE_CHECKING:
    from footcal_cli.session.session import Session


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


def _nested(table: Table) -> bool:
    """Whether every repeat of a channel lies in one session, and some session has several."""
    columns = ["channel", "session", "repeat"] if "channel" in table else ["session", "repeat"]
    pairs = set(zip(*(table.text(name).tolist() for name in columns), strict=True))
    once = len({(*p[:-2], p[-1]) for p in pairs}) == len(pairs)
    return once and len({p[:-1] for p in pairs}) < len(pairs)


def sessions_of(tables: Sequence[Table], *, pauses: bool = False) -> IntArray:
    """Number of the session of every row: file by file, and within a file by its session column.

    A log without one has repeats at most: each ladder is then a session. Else `pauses` of hours do.
    Rounds that are counted on over several days are sessions too: 4 to 6 on the second day.
    """
    numbers, first = [], 0
    for table in tables:
        name = "session" if "session" in table else "repeat" if "repeat" in table else None
        if name == "session" and "repeat" in table and _nested(table):
            name = "repeat"
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
