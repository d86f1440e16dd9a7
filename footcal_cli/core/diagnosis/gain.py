"""What the named causes buy on blocks they were not fitted to, selection included."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from footcal_cli.core.diagnosis.problem import Problem
from footcal_cli.core.diagnosis.scores import coefficients, held_out_gains, held_out_loss
from footcal_cli.core.diagnosis.search import Library, Step
from footcal_cli.core.diagnosis.whitening import whitened_grams
from footcal_cli.core.evidence import Interval, jackknife_interval, mean_interval
from footcal_cli.core.parameters import FloatArray, IntArray


@dataclass(frozen=True)
class Gain:
    """What the extended model buys on blocks it was not fitted to, per output.

    Parameters
    ----------
    output, unit
        The quantity.
    before, after
        Held-out RMS error.
    change
        Relative reduction with its 95 % interval over blocks.
    per_block
        Held-out RMS error of each block before and after, shape (B, 2).
    """

    output: str
    unit: str
    before: float
    after: float
    change: Interval
    per_block: FloatArray


def gains_of(before: Problem, after: Problem) -> tuple[Gain, ...]:
    """Held-out errors of the baseline and of the extended model, block by block."""
    losses = []
    for problem in (before, after):
        bare = replace(problem, columns=problem.columns[:, :0], signatures=())
        grams, _ = whitened_grams(bare, np.empty((problem.residual.size, 0)))
        base = grams.calibration
        losses.append(
            np.stack([held_out_loss(grams.inner, base, own) for own in grams.by_output], axis=1)
        )
    gains = []
    for o, (name, unit) in enumerate(zip(before.outputs, before.units, strict=True)):
        rows = before.output == o
        count = np.bincount(before.block[rows], minlength=before.blocks)
        used = (count > 0) & (losses[0][:, o] > 0)
        if not used.any():
            continue
        noise = float(before.noise[rows][0])
        old, new = losses[0][used, o], losses[1][used, o]
        whole = [float(np.sqrt(x.sum() / count[used].sum())) * noise for x in (old, new)]
        share = np.array(
            [
                1.0 - np.sqrt((new.sum() - n) / max(old.sum() - a, 1e-300))
                for a, n in zip(old, new, strict=True)
            ]
        )
        gains.append(
            Gain(
                name, unit, whole[0], whole[1],
                jackknife_interval(1.0 - whole[1] / max(whole[0], 1e-300), share),
                np.sqrt(np.stack([old, new], 1) / count[used, None]) * noise,
            )
        )  # fmt: skip
    return tuple(gains)


def rms_gain(loss: FloatArray, gain: FloatArray) -> Interval:
    """Relative reduction of the RMS error with a jackknife interval over blocks."""

    def share(before: float, bought: float) -> float:
        return 1.0 - float(np.sqrt(max(before - bought, 0.0) / max(before, 1e-300)))

    value = share(loss.sum(), gain.sum())
    without = np.array(
        [share(loss.sum() - a, gain.sum() - g) for a, g in zip(loss, gain, strict=True)]
    )
    return jackknife_interval(value, without)


MOST_FOLDS = 12
"""Folds of a nested cross-validation: neighbouring blocks are left out together beyond this."""


def nested_gain(lib: Library, steps: Sequence[Step]) -> Interval:
    """Repeat the selection in every fold: the gain that a new recording may expect."""
    blocks = lib.grams.blocks
    if not steps:
        return mean_interval(np.zeros(blocks))
    fold = (np.arange(blocks) * min(blocks, MOST_FOLDS)) // blocks
    starts = np.flatnonzero(np.diff(fold, prepend=-1))
    grams = replace(
        lib.grams,
        inner=np.add.reduceat(lib.grams.inner, starts, axis=0),
        plain=np.add.reduceat(lib.grams.plain, starts, axis=0),
    )
    errors = np.zeros((grams.blocks, 2))
    for b in range(grams.blocks):
        others = np.delete(np.arange(grams.blocks), b)
        chosen = _selected(replace(lib, grams=grams), others, len(steps))
        for stage, base in enumerate((grams.calibration, chosen)):
            fitted = _fit(grams.inner[others].sum(axis=0), base)
            own = grams.plain[b]
            used = np.append(base, own.shape[0] - 1)
            w = np.append(-fitted, 1.0)
            errors[b, stage] = w @ own[np.ix_(used, used)] @ w
    return rms_gain(errors[:, 0], errors[:, 0] - errors[:, 1])


def _fit(gram: FloatArray, base: IntArray) -> FloatArray:
    return coefficients(gram, base, np.array([gram.shape[0] - 1]))[:, 0]


def _selected(lib: Library, blocks: IntArray, steps: int) -> IntArray:
    """Base chosen by held-out gain on some of the blocks alone."""
    grams = lib.grams
    inner, plain = grams.inner[blocks], grams.plain[blocks]
    base = grams.calibration
    groups = list(lib.columns)
    for _ in range(steps):
        gains = held_out_gains(inner, plain, base, groups).white.sum(axis=0)
        best = int(np.argmax(gains))
        if gains[best] <= 0:
            break
        total = inner.sum(axis=0)
        drops = []
        for column in groups[best]:
            with_it = np.append(base, column)
            fitted = _fit(total, with_it)
            drops.append(fitted @ total[with_it, -1])
        base = np.append(base, groups[best][int(np.argmax(drops))])
        groups.pop(best)
    return base
