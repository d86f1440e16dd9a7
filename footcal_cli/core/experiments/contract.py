"""What an experiment is: what is physically known, and the balance that must therefore hold."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from footcal_cli.core.chain import Chain, Seen
from footcal_cli.core.effects.contract import Effect
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import BoolArray, FloatArray


@dataclass(frozen=True)
class Balance:
    """How far a log, its distortions removed, is from what the experiment demands.

    Parameters
    ----------
    outputs, units
        Names (``fz``, ``mx``, ``left_fl`` ...) and units of the columns.
    error
        Measured − demanded, shape (n, k), in `units`.
    valid
        Which errors count, shape (n, k).
    """

    outputs: tuple[str, ...]
    units: tuple[str, ...]
    error: FloatArray
    valid: BoolArray


@dataclass(frozen=True)
class Imperfection:
    """What every log of an experiment has and nobody hides: fitted beside every cause.

    Parameters
    ----------
    effect
        How it distorts a log.
    usual
        Size parameter -> sd of what is met in practice, in its unit.
    covers
        Effects of the table that a usual size of it cannot be distinguished from.
    bounded
        Whether no more than some usual sizes of it are believed.
    of_height
        Whether `usual` is a share of the height of the robot's CoM.
    """

    effect: Effect
    usual: Mapping[str, float]
    covers: tuple[str, ...] = ()
    bounded: bool = True
    of_height: bool = False

    def usual_on(self, logs: Sequence[Log]) -> Mapping[str, float]:
        """`usual` on the robot of these logs, in the parameters' units."""
        if not self.of_height:
            return self.usual
        height_m = float(np.median(np.concatenate([log.known["com_m"][:, 2] for log in logs])))
        return {name: share * height_m for name, share in self.usual.items()}


@dataclass(frozen=True)
class Experiment:
    """One way of knowing the truth beside the log.

    Parameters
    ----------
    name
        ``weights placements stand walk hang pose``.
    known
        Keys of `Log.known` it reads -> meaning with shape and unit.
    balance
        Residual of a log whose distortions are removed.
    calibration
        Names of the effects a user of this experiment always calibrates.
    imperfections
        Usual ones, which are no findings.
    few_visits
        Whether a cell is loaded at a few visits only: a jump between two of them would be any
        drift.
    """

    name: str
    known: Mapping[str, str]
    balance: Callable[[Log], Balance]
    calibration: tuple[str, ...]
    imperfections: tuple[Imperfection, ...] = ()
    few_visits: bool = False


def residual(
    experiment: Experiment,
    chain: Chain,
    log: Log,
    values: Mapping[str, float],
    seen: Seen | None = None,
    judged: Callable[[Log], Log] | None = None,
) -> Balance:
    """The one residual: a log through the inverse chain, against what the experiment demands.

    Parameters
    ----------
    seen
        What earlier calls on this log have computed; they must differ by a few columns.
    judged
        The rows of the log, its distortions removed, that are judged; all of them where None.
    """
    truth = chain.truth(log, values, seen)

    def balance(truth: Log) -> Balance:
        return experiment.balance(truth if judged is None else judged(truth))

    return balance(truth) if seen is None else seen.made_of(truth, balance)
