"""Known weights on single channels as the case that `diagnose` takes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from footcal_cli.core.bench.hands import out_of_step
from footcal_cli.core.bench.ladder import promising
from footcal_cli.core.bench.plateaus import PlateauOptions, find_plateaus
from footcal_cli.core.bench.record import BenchRecord
from footcal_cli.core.bench.regression import fit_affine
from footcal_cli.core.bench.study import ChannelStudy, find_loads
from footcal_cli.core.diagnosis.answer import Verdict
from footcal_cli.core.diagnosis.blocks import cut_blocks, even_cycles
from footcal_cli.core.diagnosis.investigation import Investigation
from footcal_cli.core.experiments.weights import EXPERIMENT
from footcal_cli.core.inference.case import Case
from footcal_cli.core.inference.written import Written
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import BoolArray, FloatArray, ParameterSet
from footcal_cli.core.quality import Finding
from footcal_cli.intake.bench import plateau_options, records_of_rows, sessions_of, studies_of
from footcal_cli.intake.cases.shared import (
    CaseRead,
    affine_parameters,
    baseline_of,
    chain_of,
    load_unit,
    needs_time,
)
from footcal_cli.intake.cases.together import read_together
from footcal_cli.recipe.options import DiagnoseOptions, OfflineFitOptions, PlateauSettings
from footcal_cli.session.inspection import weights_findings
from footcal_cli.session.uneven import uneven
from footcal_cli.tables.columns import weights_stream_table, weights_table
from footcal_cli.tables.pieces import pieces_of
from footcal_cli.tables.table import Table

if TYPE_CHECKING:
    from footcal_cli.session.session import Session

_FEWEST, _MOSTLY = 20, 0.5
_BLOCK_S, _GAP_S = 20.0, 4.0
"""Of a recording under a reference that moves slowly, and between: neighbours tell the same."""


def read(session: Session[DiagnoseOptions]) -> CaseRead:
    """One log per channel; blocks are sessions of a channel. Cells loaded together are one log."""
    together = read_together(session)
    if together is not None:
        return together
    findings: list[Finding] = []
    streams = _running(session)
    pieces: tuple[str, ...] = ()
    if streams:
        tables = streams
        logs, timed = _stream_logs(session, streams), True
    else:
        tables = session.read_required(weights_table())
        findings = [*weights_findings(tables, session.recipe.robot, None), *uneven(tables)]
        logs, timed, pieces = _row_logs(tables, plateau_options(_plateaus(session)))
    channels = tuple(dict.fromkeys(log.channels[0] for log in logs))
    chain, values = chain_of(baseline_of(session), channels, EXPERIMENT.calibration)
    values |= _affine_start(logs, values)
    largest = max(float(np.nanmax(np.abs(log.known["load_n"]))) for log in logs)
    tolerance = session.options.tolerance_n or 0.002 * largest
    case = Case(
        experiment=EXPERIMENT,
        logs=tuple(logs),
        chain=chain,
        values=values,
        calibration=ParameterSet(affine_parameters(channels, values)),
        tolerance_n=tolerance,
        tolerance_nm=session.options.tolerance_mm / 1000.0 * largest,
        # with one session per channel nothing but the session itself says what its calibration is
        drifts=max(int(log.block.max()) for log in logs) == 0,
        alike=min(len(log) for log in logs) >= 8 and not streams,
        stride=_stride(logs),
        one_recording=bool(streams),
        groups=dict.fromkeys(channels, "force"),
        written=Written({}, *load_unit(tables), pieces=dict(enumerate(pieces))),
    )
    untested = {} if timed else needs_time(EXPERIMENT, "the rows have no time stamps")
    return CaseRead(case, findings, untested)


def _row_logs(
    tables: Sequence[Table], plateaus: PlateauOptions
) -> tuple[list[Log], bool, tuple[str, ...]]:
    """One log per channel of long tables, whether rows have time stamps, and the pieces of stacks.

    Of rows that are samples of a recording only those count in which a weight lies still.
    """
    channel = np.concatenate([t.text("channel") for t in tables])
    block = sessions_of(tables, pauses=True)
    columns = {
        name: np.concatenate([t.optional(name) for t in tables])
        for name in ("load_n", "counts", "time_s", "temperature_degc")
    }
    timed = bool(np.isfinite(columns["time_s"]).all())
    known_temperature = bool(np.isfinite(columns["temperature_degc"]).all())
    pieces: tuple[str, ...] = ()
    if all("pieces" in t for t in tables):
        said = [str(text) for t in tables for text in t.text("pieces")]
        pieces, columns["pieces"] = pieces_of(said, columns["load_n"])
    logs = []
    for name in dict.fromkeys(channel):
        at = np.flatnonzero((channel == name) & np.isfinite(columns["counts"]))
        stamps = columns["time_s"][at] if timed else np.arange(float(at.size))
        order = np.lexsort((stamps, block[at]))
        at, stamps = at[order], stamps[order]
        known = {"load_n": columns["load_n"][at, None]}
        if known_temperature:
            known["temperature_degc"] = columns["temperature_degc"][at]
        if pieces:
            known["pieces"] = columns["pieces"][at]
        _, own = np.unique(block[at], return_inverse=True)
        own = own.astype(np.int64)
        counts = columns["counts"][at]
        record = BenchRecord(str(name), known["load_n"][:, 0], counts, stamps, own, timed=timed)
        if record.recorded:
            known["load_n"] = find_loads(record, plateaus, ()).settled.load_n[:, None]
        logs.append(Log("weights", (str(name),), stamps, counts[:, None], known, own))
    return logs, timed, pieces


def _running(session: Session[DiagnoseOptions]) -> list[Table]:
    """Running recordings whose loads are recorded at every sample, or given in order of time."""
    channels = session.recipe.robot.cell_names
    if not channels:
        return []
    settings = _plateaus(session)
    given = bool(settings.loads_n or settings.loads)
    tables = session.read(weights_stream_table(channels))
    return [t for t in tables if given or "load_n" in t]


def _plateaus(session: Session[DiagnoseOptions]) -> PlateauSettings:
    """What the recipe says of loads that stand still: `[offline_fit.plateaus]`."""
    given = session.recipe.options.get("offline_fit", {}).get("plateaus", {})
    return PlateauSettings.model_validate(given)


def _stream_logs(session: Session[DiagnoseOptions], tables: Sequence[Table]) -> list[Log]:
    """One log per channel of running recordings, cut into blocks."""
    logs = []
    for channel in session.recipe.robot.cell_names:
        for table in tables:
            counts, load = table.number(f"{channel}_counts"), _loads(session, table, channel)
            good = np.isfinite(counts) & (np.isfinite(load) | ("load_n" not in table))
            time_s, load = table.number("time_s")[good], load[good]
            if "load_n" in table:
                lies = at_rest(time_s, load, counts[good], _plateaus(session))
                load = np.where(lies, load, np.nan)
            known = {"load_n": load[:, None]}
            if np.isfinite(warmth := table.optional("temperature_degc")[good]).all():
                known["temperature_degc"] = warmth
            log = Log(
                "weights", (channel,), time_s, counts[good, None], known,
                np.zeros(load.size, dtype=np.int64),
            )  # fmt: skip
            logs.append(cut_blocks(log, even_cycles(log, 1.0), _BLOCK_S, _GAP_S))
    return logs


def at_rest(
    time_s: FloatArray, load: FloatArray, counts: FloatArray, settings: PlateauSettings
) -> BoolArray:
    """Samples in which a weight lies still, shape (n,); all under a reference that never does.

    While a hand puts a weight on, the load that stands there is not the one that the cell feels.
    """
    if load.size < _FEWEST or np.any(np.diff(time_s) < 0):
        return np.ones(load.size, dtype=np.bool_)
    options = plateau_options(settings)
    still = find_plateaus(time_s, load, options.of_loads).hold >= 0
    if still.mean() <= _MOSTLY:
        return np.ones_like(still)
    own = find_plateaus(time_s, counts, options)
    return np.asarray(still & ~out_of_step(time_s, load, own, options.window_s))


def _loads(session: Session[DiagnoseOptions], table: Table, channel: str) -> FloatArray:
    """The load at every sample; not a number while weights given in order of time are changed."""
    if "load_n" in table:
        return table.number("load_n")
    settings = _plateaus(session)
    counts = table.number(f"{channel}_counts")
    record = BenchRecord(
        channel, np.full(counts.size, np.nan), counts, table.number("time_s"),
        np.zeros(counts.size, dtype=np.int64),
    )  # fmt: skip
    known_n = settings.known_n(session.recipe.robot.gravity_mps2)
    samples = find_loads(record, plateau_options(settings), known_n)
    return np.asarray(np.where(samples.hold >= 0, samples.record.load_n, np.nan))


def _stride(logs: Sequence[Log]) -> int:
    """Every how many rows are judged, so that all logs together stay below 30 000."""
    return max(sum(len(log) for log in logs) // 30_000, 1)


def _affine_start(logs: Sequence[Any], values: dict[str, float]) -> dict[str, float]:
    """Scale and bias by regression for channels that no calibration covers."""
    start = {}
    for log in logs:
        channel = log.channels[0]
        if f"{channel}.scale" not in values:
            load = log.known["load_n"][:, 0]
            known = np.isfinite(load)
            fit = fit_affine(channel, load[known], log.readings[known, 0])
            start[f"{channel}.scale"] = fit.scale_n_per_count
            start[f"{channel}.bias"] = fit.bias_n
    return start


_LEVEL, _WORTH = 0.001, 0.9


def found_alone(
    session: Session[DiagnoseOptions], read: CaseRead, found: Investigation
) -> list[ChannelStudy]:
    """Cells that surely need more than a scale and a bias where none was named.

    `offline-fit` judges every cell by its own rows; a diagnosis asks for evidence from many blocks.
    What the one command surely finds the other must not deny: its own records and options are used.
    """
    case = read.case
    alone = all(len(log.channels) == 1 for log in case.logs)
    rows_of_cells = case.experiment.name == "weights" and alone and not case.one_recording
    nameless = found.verdict in (Verdict.NONE, Verdict.UNKNOWN, Verdict.UNDERPOWERED)
    if not nameless or not rows_of_cells or len(case.chain.links) > 1:
        return []
    recipe = session.recipe
    options = recipe.options_for(OfflineFitOptions, "offline_fit", {})
    records = records_of_rows(session.read_required(weights_table()), recipe.robot.adc.bits)
    # climbing the ladder of a few rows costs more than to see that nothing will come of it
    likely = [record for record in records if record.recorded or promising(record)]
    studies = studies_of(likely, options, recipe.robot.gravity_mps2, len(records))
    return [study for study in studies if _surely(study, len(case.logs))]


def _surely(study: ChannelStudy, cells: int) -> bool:
    """Whether a cell's own model is beyond chance among all cells, and worth a tenth of its error.

    Of eight straight cells one in twelve needs more at the level of `offline-fit`.
    """
    if study.ladder is None:
        return False
    climbed = [row for row in study.ladder.rows if row.climbed and row.model != "affine"]
    before, after = study.ladder.rows[0].held_out_rmse_n, study.ladder.held_out.rmse
    sure = any(row.p_value < _LEVEL / cells for row in climbed)
    return sure and after < _WORTH * before
