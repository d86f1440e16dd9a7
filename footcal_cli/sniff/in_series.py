"""Transducers in series: two in each leg, one above the other, and nothing else is known of them.

Room: sniff; asked by six_axis.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import permutations

import numpy as np

from footcal_cli.core.parameters import FloatArray
from footcal_cli.sniff.groups import AT_THE_FOOT, AXES, transducers_by_stem
from footcal_cli.sniff.guesses import ColumnGuess, FileGuess, numbers_of, seconds_of

_EXPLAINED = 0.5
"""How much of the change of force at a foot the transducer above it explains at least."""
_BLOCK_S, _LEAST_QUIET_S, _MOVED = 0.5, 2.0, 5.0
"""Means, the shortest quiet start, and how many of its scatters are a motion."""


def pairs_in_series(file: FileGuess) -> list[tuple[str, str]]:
    """Names of transducers in one leg, the upper first; empty where no leg has two that agree."""
    from footcal_cli.core.pose.series import fit_series

    groups = transducers_by_stem(file)
    step = _step(file)
    if step is None or len(groups) < 2:
        return []
    found = []
    for upper, lower in permutations(groups, 2):
        one, two = groups[upper], groups[lower]
        side = one["fz"].name.side
        if not side or side != two["fz"].name.side or not AT_THE_FOOT.search(two["fz"].column):
            continue
        if AT_THE_FOOT.search(one["fz"].column):
            continue
        first, second = _wrench(one), _wrench(two)
        good = np.isfinite(first).all(axis=1) & np.isfinite(second).all(axis=1)
        block = max(round(_BLOCK_S / step), 1)
        if good.sum() < 8 * block:
            continue
        if fit_series("", "", first[good], second[good], 2 * block, block).explained > _EXPLAINED:
            found.append((upper, lower))
    return found


def quiet_start_s(file: FileGuess, names: list[str]) -> float:
    """How long all transducers stand still at the beginning, in s; at least 2."""
    groups, step = transducers_by_stem(file), _step(file) or 1.0
    force = np.hstack([_wrench(groups[name])[:, :3] for name in names])
    block = max(round(_BLOCK_S / step), 1)
    count = len(force) // block
    means = np.nanmean(force[: count * block].reshape(count, block, -1), axis=1)
    start = means[: max(round(_LEAST_QUIET_S / _BLOCK_S), 2)]
    scatter = np.maximum(start.std(axis=0), np.nanstd(force[: 4 * block], axis=0))
    away = np.any(np.abs(means - start.mean(axis=0)) > _MOVED * scatter, axis=1)
    still = int(np.argmax(away)) if away.any() else count
    return max(still * block * step, _LEAST_QUIET_S)


def _wrench(axes: Mapping[str, ColumnGuess]) -> FloatArray:
    return np.column_stack([numbers_of(axes[a]) for a in AXES])


def _step(file: FileGuess) -> float | None:
    """Seconds from row to row."""
    for column in file.of("time"):
        at = seconds_of(column)
        if at is not None and at.size > 1 and (step := float(np.nanmedian(np.diff(at)))) > 0:
            return step
    return None
