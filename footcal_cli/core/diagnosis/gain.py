"""What the named causes buy on blocks they were not fitted to, selection included."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from footcal_cli.core.inference.evidence import Interval, effective_blocks, held_out_interval
from footcal_cli.core.inference.grams import calibration_grams
from footcal_cli.core.inference.linear import unit_columns
from footcal_cli.core.inference.problem import Problem
from footcal_cli.core.inference.refit import Refit
from footcal_cli.core.inference.scores import held_out_loss, losses_in_what_is_open
from footcal_cli.core.inference.whitening import Noise
from footcal_cli.core.parameters import FloatArray


@dataclass(frozen=True)
class Gain:
    """Errors with the extended model on blocks it was not fitted to, per output.

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

    @property
    def better_blocks(self) -> int:
        """Number of blocks whose held-out error is smaller with the names than without."""
        return int(np.sum(self.per_block[:, 1] < self.per_block[:, 0]))

    def is_confirmed(self, held: int) -> bool:
        """Whether the reduction is surely one, or is one in more than half of the blocks.

        Parameters
        ----------
        held
            Blocks in which the names act: a cause in one cell leaves those of all others as they
            were.
        """
        return self.change.low > 0.0 or self.better_blocks > 0.5 * min(held, len(self.per_block))


def gains_of(before: Problem, after: Problem, noise: Noise) -> tuple[Gain, ...]:
    """Held-out errors of the baseline and of the extended model, block by block.

    Parameters
    ----------
    before, after
        The baseline, and the problem on the extended model, `without_rivals`.
    noise
        In which both are judged.
    """
    return gains_from(before, output_losses(before, noise), output_losses(after, noise))


def gains_from(before: Problem, old_loss: FloatArray, new_loss: FloatArray) -> tuple[Gain, ...]:
    """The same from losses of blocks and outputs before and after, `output_losses`."""
    gains = []
    for o, (name, unit) in enumerate(zip(before.outputs, before.units, strict=True)):
        rows = before.output == o
        count = np.bincount(before.block[rows], minlength=before.blocks)
        used = (count > 0) & (old_loss[:, o] > 0)
        if not used.any():
            continue
        unit_noise = float(before.noise[rows][0])
        old, new = old_loss[used, o], new_loss[used, o]
        whole = [float(np.sqrt(x.sum() / count[used].sum())) * unit_noise for x in (old, new)]
        share = np.array(
            [
                1.0 - np.sqrt((new.sum() - n) / max(old.sum() - a, 1e-300))
                for a, n in zip(old, new, strict=True)
            ]
        )
        gains.append(
            Gain(
                name, unit, whole[0], whole[1],
                held_out_interval(
                    1.0 - whole[1] / max(whole[0], 1e-300), share,
                    informative=_informative(old - new),
                ),
                np.sqrt(np.stack([old, new], 1) / count[used, None]) * unit_noise,
            )
        )  # fmt: skip
    return tuple(gains)


def main_gain(gains: Sequence[Gain], problem: Problem) -> Gain | None:
    """The output where the names show most: by what they remove in units of the noise."""
    return max(gains, key=lambda gain: bought([gain], problem), default=None)


def bought(gains: Sequence[Gain], problem: Problem) -> float:
    """Squared held-out error in units of the noise that names remove, all outputs together."""
    removed = 0.0
    for gain in gains:
        rows = problem.output == problem.outputs.index(gain.output)
        unit = float(problem.noise[rows][0])
        removed += float(rows.sum()) * (gain.before**2 - gain.after**2) / unit**2
    return removed


def without_rivals(current: Problem, model: Refit | None) -> Problem:
    """The problem on an extended model, its effects fitted but not their rivals.

    What two look-alikes trade against each other in the other blocks would be off in the one block
    that tells them apart.

    Parameters
    ----------
    current
        With the rivals among what is fitted, or the baseline.
    model
        None where nothing was named.
    """
    return current if model is None else replace(current, accepted=unit_columns(model.columns))


def losses(baseline: Problem, models: Sequence[Problem], noise: Noise) -> tuple[float, float]:
    """Held-out squared error of the baseline, and of the best of some models, in one noise.

    In noise of its own every model fits alike.
    """
    grams = [calibration_grams(judged, noise) for judged in (baseline, *models)]
    before, *after = (float(held_out_loss(g.inner, g.calibration, g.plain).sum()) for g in grams)
    return before, min(after)


def removed_in_what_is_open(baseline: Problem, extended: Problem, noise: Noise) -> FloatArray:
    """What an extended model removes of each block's held-out error, shape (B,).

    Both errors are counted in what the other blocks leave open of the extended model.
    """
    open_too = extended.shared
    found = []
    for problem, free in ((baseline.holding(open_too), open_too.shape[1]), (extended, 0)):
        grams = calibration_grams(problem, noise)
        products = grams.inner.among(np.append(grams.calibration, grams.inner.last))
        fitted = np.arange(grams.calibration.size - free)
        alone = np.eye(len(products), dtype=bool)
        found.append([losses_in_what_is_open(products, fitted, one)[0] for one in alone])
    before, after = np.array(found)
    return np.asarray(before - after)


def output_losses(problem: Problem, noise: Noise) -> FloatArray:
    """Held-out squared error of each block and output in units of the noise, shape (B, outputs)."""
    grams = calibration_grams(problem, noise)
    base = grams.calibration
    return np.stack([held_out_loss(grams.inner, base, own) for own in grams.by_output], axis=1)


def _informative(gain: FloatArray) -> float:
    """Number of blocks that a gain comes from: of one cell of four, a quarter of them at most."""
    return float(effective_blocks(np.abs(gain)[:, None])[0])


def rms_gain(loss: FloatArray, gain: FloatArray) -> Interval:
    """Relative reduction of the RMS error with its interval over blocks."""

    def share(before: float, bought: float) -> float:
        return 1.0 - float(np.sqrt(max(before - bought, 0.0) / max(before, 1e-300)))

    value = share(loss.sum(), gain.sum())
    without = np.array(
        [share(loss.sum() - a, gain.sum() - g) for a, g in zip(loss, gain, strict=True)]
    )
    return held_out_interval(value, without, informative=_informative(gain))
