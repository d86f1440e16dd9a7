"""Logs and a calibration as the case that `diagnose` takes, one builder per experiment."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from footcal_cli.commands.diagnose import DiagnoseOptions
    from footcal_cli.core.chain import Chain
    from footcal_cli.core.diagnosis.case import Case
    from footcal_cli.core.log import Log
    from footcal_cli.core.parameters import FloatArray, Parameter
    from footcal_cli.core.quality import Finding
    from footcal_cli.records import ParametersRecord
    from footcal_cli.session import Session
    from footcal_cli.tables import Table

TIMED = ("creep", "creep_slow", "sensor_lag", "bias_drift", "bias_jump")
"""Effects that need time stamps."""
RECORDING_TAU_S = 2.0
"""Autocorrelation time assumed when one recording is cut into blocks."""


class CaseRead:
    """A case, what was found in the raw data, and what the logs came without.

    Parameters
    ----------
    case
        For the core.
    findings
        On raw data.
    untested
        Effect -> reason why these logs cannot test it.
    """

    def __init__(self, case: Case, findings: list[Finding], untested: dict[str, str]) -> None:
        self.case = case
        self.findings = findings
        self.untested = untested


def read_case(session: Session[DiagnoseOptions]) -> CaseRead:
    """Read the logs of the asked experiment."""
    from footcal_cli.errors import UsageError

    builders = {"weights": _weights, "placements": _placements, "walk": _balanced,
                "stand": _balanced}  # fmt: skip
    kind = session.options.experiment
    if kind not in builders:
        raise UsageError(
            f"diagnosis of '{kind}' is not available yet",
            remedy=f"available are {', '.join(builders)}",
        )
    return builders[kind](session)


def _weights(session: Session[DiagnoseOptions]) -> CaseRead:
    """One log per channel; blocks are sessions of a channel."""
    import numpy as np

    from footcal_cli.columns import weights_table
    from footcal_cli.commands.check import weights_findings
    from footcal_cli.core.diagnosis.case import Case
    from footcal_cli.core.experiments.weights import EXPERIMENT
    from footcal_cli.core.parameters import ParameterSet

    findings: list[Finding] = []
    streams = _running(session)
    if streams:
        logs, timed = _stream_logs(streams, session.recipe.robot.cell_names), True
    else:
        tables = session.read_required(weights_table())
        findings = weights_findings(tables, session.recipe, None)
        logs, timed = _row_logs(tables)
    channels = tuple(log.channels[0] for log in logs)
    chain, values = chain_of(session.parameters, channels, ("scale_bias",))
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
    )
    untested = {} if timed else dict.fromkeys(TIMED, "the rows have no time stamps")
    return CaseRead(case, findings, untested)


def _row_logs(tables: Sequence[Table]) -> tuple[list[Log], bool]:
    """One log per channel of long tables, and whether rows have time stamps."""
    import numpy as np

    from footcal_cli.core.log import Log

    channel = np.concatenate([t.text("channel") for t in tables])
    block = _sessions(tables)
    columns = {
        name: np.concatenate([_optional(t, name) for t in tables])
        for name in ("load_n", "counts", "time_s", "temperature_degc")
    }
    timed = bool(np.isfinite(columns["time_s"]).all())
    known_temperature = bool(np.isfinite(columns["temperature_degc"]).all())
    logs = []
    for name in dict.fromkeys(channel):
        at = np.flatnonzero((channel == name) & np.isfinite(columns["counts"]))
        stamps = columns["time_s"][at] if timed else np.arange(float(at.size))
        order = np.lexsort((stamps, block[at]))
        at, stamps = at[order], stamps[order]
        known = {"load_n": columns["load_n"][at, None]}
        if known_temperature:
            known["temperature_degc"] = columns["temperature_degc"][at]
        _, own = np.unique(block[at], return_inverse=True)
        logs.append(
            Log("weights", (str(name),), stamps, columns["counts"][at, None], known,
                own.astype(np.int64))
        )  # fmt: skip
    return logs, timed


def _running(session: Session[DiagnoseOptions]) -> list[Table]:
    """Running recordings with a known load at every sample, if any."""
    from footcal_cli.columns import weights_stream_table

    channels = session.recipe.robot.cell_names
    if not channels:
        return []
    tables = session.read(weights_stream_table(channels))
    return [t for t in tables if "load_n" in t]


def _stream_logs(tables: Sequence[Table], channels: Sequence[str]) -> list[Log]:
    """One log per channel of running recordings, cut into blocks."""
    import numpy as np

    from footcal_cli.core.diagnosis.case import cut_blocks, even_cycles
    from footcal_cli.core.log import Log

    logs = []
    for channel in channels:
        for table in tables:
            counts, load = table.number(f"{channel}_counts"), table.number("load_n")
            good = np.isfinite(counts) & np.isfinite(load)
            time_s = table.number("time_s")[good]
            log = Log(
                "weights", (channel,), time_s, counts[good, None], {"load_n": load[good, None]},
                np.zeros(int(good.sum()), dtype=np.int64),
            )  # fmt: skip
            # neighbouring samples of a reference that moves slowly tell the same
            logs.append(cut_blocks(log, even_cycles(log, 1.0), RECORDING_TAU_S))
    return logs


def _placements(session: Session[DiagnoseOptions]) -> CaseRead:
    """One log per foot, a row per placement and weight; blocks are holes."""
    import numpy as np

    from footcal_cli.columns import placements_table
    from footcal_cli.core.diagnosis.case import Case
    from footcal_cli.core.experiments.placements import EXPERIMENT
    from footcal_cli.core.log import Log
    from footcal_cli.core.parameters import ParameterSet
    from footcal_cli.errors import UsageError

    robot = session.recipe.robot
    cells = next((tuple(f.cells) for f in robot.feet.values() if f.cells), ())
    if not cells:
        raise UsageError(
            "the recipe names no cells of a foot", file=session.recipe.path,
            remedy="describe them in [robot.feet.<name>.cells]",
        )  # fmt: skip
    tables = session.read_required(placements_table(cells))
    foot = np.concatenate([t.text("foot") for t in tables])
    hole = np.concatenate([t.numbers(["hole_x_m", "hole_y_m"]) for t in tables])
    load = np.concatenate([t.number("load_n") for t in tables])
    counts = np.concatenate([t.numbers([f"{c}_counts" for c in cells]) for t in tables])
    stamps = np.concatenate([_optional(t, "time_s") for t in tables])
    timed = bool(np.isfinite(stamps).all())
    logs = []
    for name in dict.fromkeys(foot):
        mine = np.flatnonzero(foot == name)
        if timed:
            mine = mine[np.argsort(stamps[mine], kind="stable")]
        # readings in a row with the same weight in the same hole are one placement; a weight put
        # there again later is another, and all that lies on a hole in one go is one block
        key = np.column_stack([hole[mine].round(6), load[mine].round(6)])
        placement = np.cumsum(np.any(np.diff(key, axis=0, prepend=key[:1]) != 0, axis=1))
        number = int(placement.max()) + 1

        def mean(values: FloatArray, at: Any = mine, of: Any = placement, n: int = number) -> Any:
            return np.stack([values[at][of == p].mean(axis=0) for p in range(n)])

        place = mean(hole)
        moved = np.any(np.diff(place.round(6), axis=0, prepend=place[:1].round(6)) != 0, axis=1)
        block = np.cumsum(moved)
        when = mean(stamps) if timed else np.arange(float(number))
        position = np.array([[c.x_m, c.y_m] for c in robot.feet[str(name)].cells.values()])
        known = {
            "load_n": mean(load),
            "hole_m": place,
            "cell_pos_m": np.tile(position, (number, 1, 1)),
        }
        channels = tuple(f"{name}_{cell}" for cell in cells)
        whole = Log("placements", channels, when, mean(counts), known, block.astype(np.int64))
        rounds = _round_of(np.column_stack([place, mean(load)]).round(6))
        logs += [_rows(whole, rounds == r) for r in np.unique(rounds)]
    channels = tuple(dict.fromkeys(c for log in logs for c in log.channels))
    chain, values = chain_of(_needed(session), channels, ("scale_bias",))
    largest = float(np.max(np.abs(load)))
    case = Case(
        experiment=EXPERIMENT,
        logs=tuple(logs),
        chain=chain,
        values=values,
        calibration=ParameterSet(affine_parameters(channels, values)),
        tolerance_n=session.options.tolerance_n or 0.005 * largest,
        tolerance_nm=session.options.tolerance_mm / 1000.0 * largest,
        alike=False,
        calibration_per_log=True,
        groups={f"{foot}.{o}": o for foot in robot.feet for o in ("fz", "moment_x", "moment_y")},
    )
    untested = {} if timed else dict.fromkeys((*TIMED, "slip"), "the rows have no time stamps")
    return CaseRead(case, [], untested)


def _round_of(placement: FloatArray) -> Any:
    """How often the same weight had been put into the same hole before, shape (n,)."""
    import numpy as np

    _, kind = np.unique(placement, axis=0, return_inverse=True)
    seen: dict[int, int] = {}
    rounds = np.empty(len(placement), dtype=np.int64)
    for i, k in enumerate(kind.ravel().tolist()):
        rounds[i] = seen.get(k, 0)
        seen[k] = rounds[i] + 1
    return rounds


def _balanced(session: Session[DiagnoseOptions]) -> CaseRead:
    """Standing and walking: merged streams, blocks of whole gait cycles or stances."""
    import numpy as np

    from footcal_cli.core.contact import gait_cycles
    from footcal_cli.core.diagnosis.case import Case, block_means, cut_blocks, even_cycles
    from footcal_cli.core.diagnosis.tracking import gain_and_bias
    from footcal_cli.core.experiments import stand, walk
    from footcal_cli.core.online.streams import MergeRule
    from footcal_cli.core.parameters import ParameterSet
    from footcal_cli.errors import UsageError
    from footcal_cli.intake import read_recordings

    kind = session.options.experiment
    experiment = walk.EXPERIMENT if kind == "walk" else stand.EXPERIMENT
    recordings = read_recordings(session, MergeRule(), kind)
    if any(r.belief is None for r in recordings):
        raise UsageError(
            "diagnosis of six-axis feet is not available yet", remedy="use load cells, or 'hang'"
        )
    findings: list[Finding] = []
    logs = []
    for recording in recordings:
        log = recording.merged.log
        good = np.isfinite(log.readings).all(axis=1)
        for name in experiment.known:
            if name != "contact" and name in log.known:
                array = log.known[name].reshape(len(log), -1)
                good &= np.isfinite(array).all(axis=1)
        log = _rows(log, good)
        cycle = gait_cycles(log.known["contact"])
        if kind == "stand" or cycle.max(initial=-1) < 10:
            cycle = even_cycles(log, 0.5)
        cut = cut_blocks(log, cycle, 0.3)
        logs.append(block_means(cut) if kind == "stand" else cut)
    channels = logs[0].channels
    chain, values = chain_of(session.parameters, channels, ("scale_bias",))
    belief = recordings[0].belief
    if belief is not None:
        for i, channel in enumerate(channels):
            values.setdefault(f"{channel}.scale", float(belief.scale_n_per_count[i]))
            values.setdefault(f"{channel}.bias", float(belief.bias_n[i]))
    weight = session.recipe.robot.weight_n or 50.0
    rate = 1.0 / float(np.median(np.diff(logs[0].time_s)))
    case = Case(
        experiment=experiment,
        logs=tuple(logs),
        chain=chain,
        values=values,
        calibration=ParameterSet(affine_parameters(channels, values)),
        tolerance_n=session.options.tolerance_n or 0.001 * weight,
        tolerance_nm=session.options.tolerance_mm / 1000.0 * weight / 10.0,
        drifts=kind == "walk",
        alike=False,
        stride=max(round(rate / 20.0), 1),
        groups=dict.fromkeys(channels, "swing"),
        one_recording=len(logs) == 1,
        directions=gain_and_bias(channels, values) if kind == "walk" else (),
        demand_noisy=kind == "walk",
    )
    return CaseRead(case, findings, {})


def _stride(logs: Sequence[Log]) -> int:
    """Every how many rows are judged, so that all logs together stay below 30 000."""
    return max(sum(len(log) for log in logs) // 30_000, 1)


def _rows(log: Any, good: Any) -> Any:
    """A log's rows where everything is known."""
    from dataclasses import replace

    return replace(
        log,
        time_s=log.time_s[good],
        readings=log.readings[good],
        known={name: array[good] for name, array in log.known.items()},
        block=log.block[good],
    )


def _optional(table: Table, name: str) -> FloatArray:
    import numpy as np

    return table.number(name) if name in table else np.full(len(table), np.nan)


def _sessions(tables: Sequence[Table]) -> Any:
    """Session number of each row: by file, and within it by its session or repeat column."""
    import numpy as np

    numbers, first = [], 0
    for table in tables:
        name = "session" if "session" in table else "repeat" if "repeat" in table else None
        labels: Any = table.text(name) if name else np.zeros(len(table), dtype=object)
        _, index = np.unique(labels.astype(str), return_inverse=True)
        numbers.append(index.astype(np.int64) + first)
        first = int(numbers[-1].max()) + 1
    return np.concatenate(numbers)


def _needed(session: Session[DiagnoseOptions]) -> ParametersRecord:
    from footcal_cli.errors import UsageError

    if session.parameters is None:
        raise UsageError(
            "diagnosis of placements starts from a calibration",
            remedy="give --parameters from offline-fit",
        )
    return session.parameters


def chain_of(
    record: ParametersRecord | None, channels: Sequence[str], calibration: Sequence[str]
) -> tuple[Chain, dict[str, float]]:
    """The chain that a calibration describes, its effects included, and its values."""
    from footcal_cli.core.chain import Chain, Link, link
    from footcal_cli.core.effects import find_effect

    chain = Chain(())
    for name in calibration:
        chain = chain.with_link(link(find_effect(name), channels))
    values: dict[str, float] = {}
    if record is not None:
        values = {name: parameter.value for name, parameter in record.parameters.items()}
        for item in record.effects:
            if item.effect not in calibration:
                chain = chain.with_link(Link(find_effect(item.effect), dict(item.owners)))
    return chain, values


def affine_parameters(channels: Sequence[str], values: dict[str, float]) -> tuple[Parameter, ...]:
    """Scale and bias of each channel as parameters that the data alone determine."""
    from footcal_cli.core.parameters import Parameter

    found = []
    for channel in channels:
        scale = values[f"{channel}.scale"]
        found.append(
            Parameter(f"{channel}.scale", "N/count", scale, scale=max(0.02 * abs(scale), 1e-12))
        )
        found.append(Parameter(f"{channel}.bias", "N", values[f"{channel}.bias"], scale=0.3))
    return tuple(found)


def _affine_start(logs: Sequence[Any], values: dict[str, float]) -> dict[str, float]:
    """Scale and bias by regression for channels that no calibration covers."""
    import numpy as np

    from footcal_cli.core.bench.regression import fit_affine

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
