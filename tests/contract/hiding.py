"""Effects hidden at twice the smallest size that matters, by simulating what they do.

The size is that at which an effect's visible part, what a refitted calibration leaves of it,
changes an output by twice the tolerance of the command; `diagnose` is not asked.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from footcal_cli.core.diagnosis.bridge import problem_from
from footcal_cli.core.diagnosis.investigation import Investigation, investigate
from footcal_cli.core.diagnosis.rules import Rules
from footcal_cli.core.diagnosis.signals import describe
from footcal_cli.core.effects import TABLE
from footcal_cli.core.effects.contract import Effect, GridOf, Scope, columns_of
from footcal_cli.core.inference.case import Case, residual, rows_of
from footcal_cli.core.inference.grams import whitened_grams
from footcal_cli.core.inference.problem import Problem, Signature
from footcal_cli.core.inference.signatures import SWITCHES
from footcal_cli.core.parameters import FloatArray
from tests.contract.worlds import WORLDS, Hidden

TIMES_WHAT_MATTERS = 2.0
ONE_CELL = frozenset({"sign_flip", "cell_position", "bias_drift", "bias_jump"})
"""Effects of single cells; what is in the nature of a sensor all of them have alike."""
SATURATION = "saturation"
"""Whole, or none: its size is the load at which it begins."""
PARAMETERS = {
    "cross_coupling": "coupling_fx_fz", "scale_matrix": "gain_fz", "axis_flip": "flip_fx",
    "offset_drift": "offset_drift_fz", "offset_change": "offset_change_fy",
}  # fmt: skip
"""Which size is hidden, where it is not the first."""
SHAPES = {
    "saturation_limit": 1.0, "hinge_load": 0.5, "dead_zone_width": 0.15, "bypass_load": 0.5,
    "hysteresis_reach": 0.15, "change_time": 0.43,
    "creep_time": 45.0, "creep_slow_time": 800.0, "jump_time": 45.0, "slip_time": 25.0,
    "drift_settling": 0.0,
    "slip_duration": 0.3, "label": 10.0, "hole": 5.0,
    "swap_first": 0.0, "swap_second": 2.0, "crosstalk_from": 0.0, "strain_bridged": 0.0,
}  # fmt: skip
"""Mostly between the values that `diagnose` tries; of the largest load (or of a log's span)."""
LABELS_N = {"weights": 10.0, "placements": 19.61}


@dataclass(frozen=True)
class Clean:
    """An experiment with nothing hidden in it.

    Parameters
    ----------
    case, rows, problem
        With noise; the problem has no candidates.
    still
        Residual of the same recording without noise, shape (m,).
    """

    case: Case
    rows: Problem
    problem: Problem
    still: FloatArray


@dataclass(frozen=True)
class Seen:
    """What of an effect shows.

    Parameters
    ----------
    matters
        Largest change of an output over the smallest that matters, calibration refitted.
    rho
        RMS of that part over the RMS of the noise, on the outputs it touches.
    fraction
        Share of the effect that calibration cannot absorb.
    whole
        As `matters`, calibration held.
    """

    matters: float
    rho: float
    fraction: float
    whole: float


@cache
def clean(experiment: str, seed: int) -> Clean:
    world = WORLDS[experiment]
    case = world.case(world.record(None, seed, True), seed)
    rows = rows_of(case)
    quiet = replace(case, logs=world.record(None, seed, False))
    problem = problem_from(case, rows, (), describe)
    return Clean(case, rows, problem, residual(quiet, rows, case.values))


def seen(experiment: str, seed: int, hidden: Hidden) -> Seen:
    """What a hidden effect does to the residual, by two recordings without noise."""
    base = clean(experiment, seed)
    quiet = replace(base.case, logs=WORLDS[experiment].record(hidden, seed, False))
    change = residual(quiet, base.rows, base.case.values) - base.still
    column = Signature(hidden.effect.name, hidden.parameter, "", "")
    problem = replace(base.problem, columns=change[:, None], signatures=(column,))
    whole = _matters(problem, change)
    if problem.tracking is not None:
        return replace(_tracked(problem), whole=whole)
    left = problem.left()
    noise = replace(problem, columns=problem.residual[:, None]).left()[:, 0]
    touched = np.isin(problem.output, np.unique(problem.output[change != 0.0]))
    rho = _rms(left[touched, 0]) / _rms(noise[touched]) if touched.any() else 0.0
    return Seen(_matters(problem, left[:, 0]), rho, float(problem.visible(left)[0]), whole)


def diagnosed(experiment: str, case: Case, seed: int) -> Investigation:
    """What the command says of a case: with the whole table but for what it does not try."""
    untested = WORLDS[experiment].untested
    table = {name: row for name, row in TABLE.items() if name not in untested}
    return investigate(case, table, describe, Rules(), seed)


def _matters(problem: Problem, left: FloatArray) -> float:
    """Largest RMS change of an output over its tolerance; one cell's counts on that cell's rows."""
    largest = 0.0
    for o, tolerance in enumerate(problem.tolerance):
        rows = problem.output == o
        own = rows & (problem.columns[:, 0] != 0.0)
        rows = own if own.any() else rows
        if rows.any():
            largest = max(largest, _rms((left * problem.noise)[rows]) / float(tolerance))
    return largest


def _tracked(problem: Problem) -> Seen:
    """The same where the calibration is followed: of what its prediction misses."""
    grams, _ = whitened_grams(problem, np.empty((problem.residual.size, 0)))
    column = int(grams.candidates[0])
    rows = np.bincount(problem.output, minlength=len(problem.outputs))
    noise = np.array([problem.noise[problem.output == o][0] for o in range(rows.size)])
    rms = np.sqrt(grams.energy[:, [column, -1]] / rows[:, None])
    touched = rms[:, 0] > 0.0
    if not touched.any():
        return Seen(0.0, 0.0, 0.0, 0.0)
    energy = grams.energy[touched].sum(axis=0)
    matters = float(np.max(rms[:, 0] * noise / problem.tolerance))
    return Seen(matters, float(np.sqrt(energy[column] / energy[-1])),
                float(grams.visible[column]), 0.0)  # fmt: skip


def _rms(values: FloatArray) -> float:
    return float(np.sqrt(np.mean(values**2)))


def hidden_in(experiment: str, effect: Effect, seed: int) -> Hidden:
    """The effect in those who carry it, at its usual size."""
    base = clean(experiment, seed)
    channels = tuple(c for log in base.case.logs for c in log.channels)
    owners: dict[str, tuple[str, ...]] = {}
    if effect.scope is Scope.ROBOT:
        owners = {"robot": ("robot",)}
    elif effect.scope is Scope.LEG:
        owners = {"fl": ("fl",)}
    elif effect.scope is Scope.FOOT:
        owners = {"left": ("left",)} if effect.name == "slip" else {"all": ("left", "right")}
    elif "." in channels[0]:
        owners = {"fl.fz": ("fl.fz",)}
    elif effect.name in ONE_CELL:
        owners = {channels[1]: (channels[1],)}
    else:
        owners = {"all": channels}
    parameter = PARAMETERS.get(effect.name, effect.size.name)
    size = next(p for p in effect.sizes if p.name == parameter)
    shown = {p.name: _shape(experiment, effect, p.name, p.grid_of, seed) for p in effect.shapes}
    whole = effect.name in (*SWITCHES, SATURATION)
    shown[parameter] = 1.0 if whole else size.neutral + size.prior_sd
    values = {f"{owner}.{name}": value for owner in owners for name, value in shown.items()}
    return Hidden(effect, owners, parameter, values)


def _shape(experiment: str, effect: Effect, name: str, of: GridOf, seed: int) -> float:
    if name == "label":
        return LABELS_N[experiment]
    share = SHAPES[name]
    case = clean(experiment, seed).case
    if of is GridOf.SPAN:
        return share * float(max(np.ptp(log.time_s) for log in case.logs))
    if of is not GridOf.LOAD:
        return share
    largest = 0.0
    for log in case.logs:
        force = np.abs(case.chain.remove(log, case.values)[0].readings)
        units = columns_of(effect.scope, log.channels)
        sums = np.stack([force[:, c].sum(axis=1) for c in units], axis=1)
        largest = max(largest, float(np.quantile(sums, 0.99, axis=0).max()))
    return share * largest


def sized(experiment: str, effect: Effect, seed: int) -> tuple[Hidden, Seen]:
    """The effect at twice the smallest size that matters, or at the largest there is.

    Where calibration takes it up, or the command says so, the size is that of the whole effect.
    """
    absorbed = effect.name in WORLDS[experiment].untested
    hidden = hidden_in(experiment, effect, seed)
    found = seen(experiment, seed, hidden)
    if effect.name in SWITCHES:
        return hidden, found
    if effect.name == SATURATION:
        return _saturated(experiment, hidden, seed)
    size = next(p for p in effect.sizes if p.name == hidden.parameter)
    for _ in range(6):
        absorbed |= found.fraction < Rules().visible_floor
        shown = found.whole if absorbed else found.matters
        if shown == 0.0 or abs(shown / TIMES_WHAT_MATTERS - 1.0) < 0.01:
            break
        wanted = hidden.size * TIMES_WHAT_MATTERS / shown
        wanted = float(np.clip(wanted, size.lower, size.upper))
        if wanted == hidden.size:
            break
        hidden = hidden.resized(wanted)
        found = seen(experiment, seed, hidden)
    return hidden, found


def _saturated(experiment: str, hidden: Hidden, seed: int) -> tuple[Hidden, Seen]:
    """Bisect the load above which nothing more is read: the lower, the more matters."""
    (limit,) = [name for name in hidden.values if name.endswith(".saturation_limit")]
    low, high = 0.3, 1.2
    for _ in range(12):
        share = 0.5 * (low + high)
        tried = replace(hidden, values={**hidden.values, limit: share * hidden.values[limit]})
        found = seen(experiment, seed, tried)
        low, high = (share, high) if found.matters > TIMES_WHAT_MATTERS else (low, share)
    return tried, found
