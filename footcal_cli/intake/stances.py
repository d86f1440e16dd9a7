"""Stances of all recordings: their rows, and what to stand like next."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from footcal_cli.core.effects.contract import Scope, columns_of
from footcal_cli.core.inference.observability import NextStep
from footcal_cli.core.next_stance import next_stances
from footcal_cli.core.parameters import BoolArray
from footcal_cli.core.quiet import QuietRule, QuietSet, select_quiet
from footcal_cli.core.stances import StanceRows
from footcal_cli.core.static_init import without_false_lifts
from footcal_cli.errors import FitError
from footcal_cli.intake.recordings import Recording
from footcal_cli.recipe.options import StaticInitOptions

if TYPE_CHECKING:
    from footcal_cli.recipe import Recipe


def all_stances(
    options: StaticInitOptions,
    recordings: Sequence[Recording],
    rows_of: Callable[[Recording, QuietSet], StanceRows],
) -> tuple[StanceRows, list[QuietSet]]:
    """Rows of the stances of all logs, one after the other."""
    parts, quiet, offset = [], [], 0
    for recording in recordings:
        recording = _shortened(recording, options.until_s)
        chosen = _quiet(options, recording)
        part = rows_of(recording, chosen)
        parts.append(replace(part, stance=part.stance + offset))
        offset += chosen.stances
        quiet.append(chosen)
    first = parts[0]
    joined = replace(
        first,
        h=np.concatenate([p.h for p in parts]),
        error=np.concatenate([p.error for p in parts]),
        sd=np.concatenate([p.sd for p in parts]),
        shared=np.concatenate([p.shared for p in parts]),
        output=tuple(name for p in parts for name in p.output),
        stance=np.concatenate([p.stance for p in parts]),
        effective_samples=np.concatenate([p.effective_samples for p in parts]),
    )
    return without_false_lifts(joined), quiet


def judged_rows(recipe: Recipe, kind: str, recording: Recording) -> BoolArray:
    """Rows that `diagnose` judges, shape (n,): of a stand those that `static-init` takes.

    All of a walk, and of a stand in which nothing is quiet.
    """
    if kind == "stand":
        try:
            asked = recipe.options_for(StaticInitOptions, "static_init")
            return _quiet(asked, recording).stance >= 0
        except FitError:
            pass
    return np.ones(len(recording.merged.log), dtype=bool)


def _quiet(options: StaticInitOptions, recording: Recording) -> QuietSet:
    rule = QuietRule(
        warm_s=options.warm_s,
        acceleration_mps2=options.largest_acceleration_mps2,
        rate_radps=options.largest_rate_radps,
        min_force_n=options.min_force_n,
        least_samples=options.least_samples,
    )
    log, belief = recording.merged.log, recording.belief
    forces = log.readings if belief is None else belief.forces(log.readings)
    return select_quiet(log, forces, gyro_radps=recording.merged.imu_gyro_radps, rule=rule)


def _shortened(recording: Recording, until_s: float | None) -> Recording:
    """The first seconds of a recording."""
    if until_s is None:
        return recording
    log = recording.merged.log
    stop = int(np.searchsorted(log.time_s, log.time_s[0] + until_s))
    gyro = recording.merged.imu_gyro_radps
    merged = replace(
        recording.merged,
        log=log.rows(0, stop),
        imu_gyro_radps=None if gyro is None else gyro[:stop],
    )
    return replace(recording, merged=merged)


def next_menu(
    recordings: Sequence[Recording], quiet: Sequence[QuietSet], rows: StanceRows, weight_n: float
) -> list[NextStep]:
    """What to stand like next, from the last stance; nothing where its feet are unknown."""
    last = recordings[-1]
    if last.no_body or last.belief is None:
        return []
    inside = quiet[-1].stance == quiet[-1].stances - 1
    cells = np.nanmean(last.merged.log.known["cell_pos_m"][inside], axis=0)
    feet = [[int(i) for i in c] for c in columns_of(Scope.FOOT, last.merged.log.channels)]
    return next_stances(rows, cells, feet, last.feet, weight_n, last.belief)
