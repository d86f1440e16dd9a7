"""Weights on the holes of a plate as the case that `diagnose` takes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from footcal_cli.core.bench.odd_gain import gain_finding, odd_gain_of
from footcal_cli.core.checks.holes import check_placed
from footcal_cli.core.diagnosis.labels import Elsewhere, Misloaded, misloaded, relabelled
from footcal_cli.core.effects import having
from footcal_cli.core.effects.contract import Trait
from footcal_cli.core.experiments.placements import EXPERIMENT
from footcal_cli.core.inference.case import Case
from footcal_cli.core.inference.written import Written
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import FloatArray, IntArray, ParameterSet
from footcal_cli.core.quality import Finding
from footcal_cli.errors import UsageError
from footcal_cli.intake.cases.shared import (
    CaseRead,
    affine_parameters,
    chain_of,
    in_order,
    known_before,
    load_unit,
    needs_time,
)
from footcal_cli.intake.empty_plate import carried
from footcal_cli.intake.placed_weights import believed_cells, read_placements
from footcal_cli.intake.zeros import use_zeros
from footcal_cli.recipe.options import DiagnoseOptions
from footcal_cli.records.results import ParametersRecord
from footcal_cli.tables.columns import placements_table
from footcal_cli.tables.table import Table

_CARRIES = 0.1
"""Share of the largest weight from which cells carry one: below there is no CoP."""
PLACEMENT_S = 20.0
"""How long a placement takes, about, where no stamp says it."""

if TYPE_CHECKING:
    from footcal_cli.session.session import Session


def read(session: Session[DiagnoseOptions]) -> CaseRead:
    """One log per foot, a row per placement and weight; blocks are holes."""
    findings: list[Finding] = []
    robot = session.recipe.robot
    cells = next((tuple(f.cells) for f in robot.feet.values() if f.cells), ())
    if not cells:
        raise session.lacks(
            "no cells of a foot are described", "add [robot.feet.<name>.cells] to the recipe"
        )
    tables = session.read_required(placements_table(cells))
    foot = np.concatenate([t.text("foot") for t in tables])
    hole = np.concatenate([t.numbers(["hole_x_m", "hole_y_m"]) for t in tables])
    load = np.concatenate([t.number("load_n") for t in tables])
    counts = np.concatenate([t.numbers([f"{c}_counts" for c in cells]) for t in tables])
    stamps, warmth = (
        np.concatenate([t.optional(name) for t in tables])
        for name in ("time_s", "temperature_degc")
    )
    placed, each_foot = np.column_stack([hole, load]), [foot == name for name in np.unique(foot)]
    timed = bool(np.isfinite(stamps).all()) and all(
        _of_one_clock(stamps[mine], placed[mine]) for mine in each_foot
    )
    logs = []
    known = {} if session.parameters is None else session.parameters.calibrated_cells
    for name in dict.fromkeys(foot):
        mine = np.flatnonzero(foot == name)
        if all(f"{name}_{cell}" in known for cell in cells):
            each = np.array([known[f"{name}_{cell}"][0] for cell in cells])
            mine = mine[~carried(counts[mine] * each, load[mine])]
        if timed:
            mine = mine[np.argsort(stamps[mine], kind="stable")]
        when = stamps[mine] if timed else None
        position = np.array([[c.x_m, c.y_m] for c in robot.feet[str(name)].cells.values()])
        channels = tuple(f"{name}_{cell}" for cell in cells)
        warm = warmth[mine] if np.isfinite(warmth).all() else None
        logs.append(_log_of(channels, position, hole[mine], load[mine], counts[mine], when, warm))
    channels = tuple(dict.fromkeys(c for log in logs for c in log.channels))
    if session.parameters is not None:
        use_zeros(session, channels)
    chain, values = chain_of(_needed(session), channels, EXPERIMENT.calibration)
    for log in logs:
        scale, bias = ([values[f"{c}.{n}"] for c in log.channels] for n in ("scale", "bias"))
        forces = log.readings * scale + bias
        findings += check_placed(forces, log.channels, log.known["load_n"])
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
        setting_key="round",
        known=known_before(session, channels, values),
        groups={f"{foot}.{o}": o for foot in robot.feet for o in ("fz", "moment_x", "moment_y")},
    )
    case, elsewhere = relabelled(case)
    name = np.concatenate([t.text("placement") for t in tables])
    unit, newtons = load_unit(tables)
    holes = holes_written(case, foot, hole, np.where(load != 0.0, name, ""))
    case = replace(case, written=Written(holes, unit, newtons))
    findings += [*_labels_found(elsewhere), *_loads_found(misloaded(case), case.written)]
    findings += _gains_found(session, tables)
    untested, instead = _left_out_with(session, load), {}
    if not timed and not any(_sorted(log) for log in logs):
        instead = in_order(EXPERIMENT, "placement", PLACEMENT_S)
    elif not timed:
        untested |= needs_time(EXPERIMENT, "the rows have no time stamps and are sorted")
    return CaseRead(case, findings, untested, instead)


def holes_written(
    case: Case, foot: NDArray[Any], hole_m: FloatArray, name: NDArray[Any]
) -> dict[int, str]:
    """Number of a hole -> its name in the log and its place, of each foot that has it.

    Parameters
    ----------
    foot, hole_m, name
        Of every row: foot, place and name, shapes (n,), (n, 2), (n,); no name of an empty plate.
    """
    found: dict[int, list[str]] = {}
    for log in case.logs:
        own = log.channels[0].rpartition("_")[0]
        places: list[tuple[float, ...]] = []
        for number in np.unique(log.known["hole"]).tolist():
            at = log.known["hole_m"][log.known["hole"] == number][0]
            there = (foot == own) & np.all(np.abs(hole_m - at) < 1e-6, axis=1)
            names = {str(n) for n in name[there]} - {""}
            said = f"hole {names.pop()}" if len(names) == 1 else "hole"
            place = f"{1000 * at[0]:.5g}, {1000 * at[1]:.5g} mm".replace("-", "−")
            again = "some visits to " if tuple(at) in places else ""
            which = f" of {own}" if len(case.logs) > 1 else ""
            found.setdefault(int(number), []).append(f"{again}{said} at {place}{which}")
            places.append(tuple(at))
    return {number: " or ".join(names) for number, names in found.items()}


def _sorted(log: Log) -> bool:
    """Whether rows stand in the order of their holes or loads, which is none of time."""
    columns = np.column_stack([log.known["hole_m"], log.known["load_n"]])
    steps = np.diff(columns[:, np.ptp(columns, axis=0) > 0], axis=0)
    return bool(np.any(np.all(steps >= 0, axis=0) | np.all(steps <= 0, axis=0)))


def _log_of(
    channels: tuple[str, ...],
    position_m: FloatArray,
    hole_m: FloatArray,
    load_n: FloatArray,
    counts: FloatArray,
    stamps: FloatArray | None,
    temperature_degc: FloatArray | None,
) -> Log:
    """The placements of one foot from its readings in their order.

    Readings in a row with the same weight in the same hole are one placement; a weight put there
    again later is another, and all that lies on a hole in one go is one block.
    """
    placement = _in_a_row(np.column_stack([hole_m, load_n]))
    number = int(placement.max()) + 1

    def mean(values: FloatArray) -> FloatArray:
        return np.stack([values[placement == p].mean(axis=0) for p in range(number)])

    place = mean(hole_m)
    moved = np.any(np.diff(place.round(6), axis=0, prepend=place[:1].round(6)) != 0, axis=1)
    known = {
        "load_n": mean(load_n),
        "hole_m": place,
        "hole": np.unique(place.round(6), axis=0, return_inverse=True)[1].ravel(),
        "cell_pos_m": np.tile(position_m, (number, 1, 1)),
        "round": _round_of(np.column_stack([place, mean(load_n)]).round(6)),
    }
    if temperature_degc is not None:
        known["temperature_degc"] = mean(temperature_degc)
    when = np.arange(float(number)) if stamps is None else mean(stamps)
    block = np.cumsum(moved).astype(np.int64)
    return Log("placements", channels, when, mean(counts), known, block)


def _in_a_row(placed: FloatArray) -> IntArray:
    """Number of the placement of each row: rows of one follow one another, shape (n,)."""
    key = placed.round(6)
    return np.cumsum(np.any(np.diff(key, axis=0, prepend=key[:1]) != 0, axis=1))


def _of_one_clock(stamps: FloatArray, placed: FloatArray) -> bool:
    """Whether placements follow one another by their stamps; not where each file begins at zero."""
    order = np.argsort(stamps, kind="stable")
    return bool(_in_a_row(placed[order]).max() <= _in_a_row(placed).max())


def _gains_found(session: Session[DiagnoseOptions], tables: Sequence[Table]) -> list[Finding]:
    """A cell whose gain alone explains what placements show of a calibration that is believed.

    Placements that calibrated cells which no weights had measured hold no error of a gain any more.
    """
    robot = session.recipe.robot
    if session.recipe.data_paths("weights") or robot.nameplate.scale_n_per_count is None:
        return []
    known = {} if session.parameters is None else session.parameters.calibrated_cells
    believed = dict[str, tuple[float, float]]()
    for one in believed_cells(robot, tables):
        channel, scale = one.names[0].removesuffix(".scale"), float(one.values[0])
        used, bias = known.get(channel, (scale, float(one.values[1])))  # zeros are these logs'
        believed[channel] = (scale, bias * scale / used)
    heaviest = max(float(np.abs(table.number("load_n")).max()) for table in tables)
    logs = read_placements(tables, robot, believed, _CARRIES * heaviest, believed=True)
    return [gain_finding(odd) for log in logs.values() if (odd := odd_gain_of(log.rows))]


def _labels_found(elsewhere: Sequence[Elsewhere]) -> list[Finding]:
    """Visits whose weight lay elsewhere than their label says, in words."""

    def place(at_m: FloatArray) -> str:
        return f"({1000 * at_m[0]:.1f}, {1000 * at_m[1]:.1f}) mm"

    return [
        Finding(
            "hole_elsewhere", "warning", one.foot,
            f"{one.visits} of {one.of} visits to the hole {place(one.written_m)}: as if at "
            + (f"the hole {place(one.nearest_m)}" if one.nearest_m is not None
               else f"{place(one.seems_m)}, where no hole is in use"),
            "put a weight into that hole once more, and correct the label of these visits",
        )
        for one in elsewhere
    ]  # fmt: skip


def _loads_found(otherwise: Sequence[Misloaded], written: Written) -> list[Finding]:
    """Placements whose weight was another one than their label says, in words."""
    unit, one_n = written.load_unit, written.load_n
    return [
        Finding(
            "weight_otherwise", "warning", one.foot,
            f"{written.holes.get(one.hole, 'a hole')}, written {one.written_n / one_n:.5g} {unit}: "
            f"the cells carry {abs(one.off_n) / one_n:.3g} {unit} "
            f"{'more' if one.off_n > 0 else 'less'} ({one.times:.0f} times what placements "
            "scatter), and in the right place",
            "look up which weight lay there, and correct the label or repeat this placement",
        )
        for one in otherwise
    ]  # fmt: skip


FEW_WEIGHTS = 3
"""With so few weights a wrong label and load beside the cells make the same error."""


def _left_out_with(session: Session[DiagnoseOptions], load_n: FloatArray) -> dict[str, str]:
    """What goes with an effect that was left out: its exact copy on so few weights."""
    if np.unique(load_n.round(6)).size > FEW_WEIGHTS:
        return {}
    alike = having(Trait.OF_THE_SUM)
    out = ", ".join(sorted(alike & set(session.options.without)))
    reason = f"on so few weights it is the same as {out}, which was left out"
    return dict.fromkeys(sorted(alike - set(session.options.without)), reason) if out else {}


def _round_of(placement: FloatArray) -> Any:
    """How often the same weight had been put into the same hole before, shape (n,)."""
    _, kind = np.unique(placement, axis=0, return_inverse=True)
    seen: dict[int, int] = {}
    rounds = np.empty(len(placement))
    for i, k in enumerate(kind.ravel().tolist()):
        rounds[i] = seen.get(k, 0)
        seen[k] = rounds[i] + 1
    return rounds


def _needed(session: Session[DiagnoseOptions]) -> ParametersRecord:
    if session.parameters is None:
        raise UsageError(
            "diagnosis of placements starts from a calibration",
            remedy="give --parameters from offline-fit",
        )
    return session.parameters
