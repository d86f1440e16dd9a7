"""What one experiment says of the size of a cause, for the joint diagnosis of several.

Each experiment keeps the noise and the calibration of its own diagnosis. Of a cause it says the
size that its data prefer, beside calibration and the other causes, and how sure that is.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from footcal_cli.core.diagnosis.answer import EffectStatus, Verdict
from footcal_cli.core.diagnosis.investigation import Found, Investigation
from footcal_cli.core.inference.evidence import effective_blocks
from footcal_cli.core.inference.grams import Grams, whitened_grams
from footcal_cli.core.inference.problem import Signature
from footcal_cli.core.inference.scores import coefficients, scores
from footcal_cli.core.parameters import IntArray

_CERTAIN = (Verdict.NAMED, Verdict.AMBIGUOUS, Verdict.NAMED_UNKNOWN)
_SHORT = 1e-3
"""Of shapes that are zero, so that their logarithm exists."""


@dataclass(frozen=True)
class JointCause:
    """A cause that several experiments may see.

    Parameters
    ----------
    effect, parameter, unit
        Of its size.
    groups
        Units (cells, feet, legs) that share a size; of a cause with one size for all, one group.
    where
        In words.
    shape
        Values of the shape parameters.
    """

    effect: str
    parameter: str
    unit: str
    groups: tuple[frozenset[str], ...]
    where: str
    shape: tuple[tuple[str, float], ...] = ()

    def owner_of(self, group: frozenset[str]) -> str:
        """A name for those who share a size: their foot, if they have one in common, or all."""
        feet = {unit.split("_", 1)[0] for unit in group}
        return feet.pop() if len(feet) == 1 else "all"


@dataclass(frozen=True)
class SizeSeen:
    """The size of a cause in one experiment, ``t = (size − b) / sd`` with Student's law.

    Parameters
    ----------
    size, sd
        In the unit of the effect.
    freedom
        Informative blocks less one.
    """

    size: float
    sd: float
    freedom: float

    @property
    def sureness(self) -> float:
        """How many sd it is from nothing."""
        return abs(self.size) / max(self.sd, 1e-300)


@dataclass(frozen=True, eq=False)
class SingleDiagnosis:
    """One experiment of several, diagnosed by itself.

    Parameters
    ----------
    name
        What the user calls it.
    found
        Its own diagnosis.
    untested
        Effect -> why these logs cannot test it.
    """

    name: str
    found: Investigation
    untested: Mapping[str, str]

    @property
    def kind(self) -> str:
        """Its experiment."""
        return self.found.case.experiment.name

    @property
    def findings(self) -> tuple[Found, ...]:
        """What it names, each with its rivals."""
        return self.found.found if self.found.verdict in _CERTAIN else ()

    @cached_property
    def grams(self) -> Grams:
        """All candidates beside the calibration, in the noise that is left beside its names."""
        problem = self.found.problem
        nothing = np.empty((problem.residual.size, 0))
        return whitened_grams(problem, nothing, self.found.final.law, counted=False)[0]

    @cached_property
    def units(self) -> Mapping[str, frozenset[str]]:
        """Effect -> who may carry it here."""
        found: dict[str, frozenset[str]] = {}
        for signature in self.found.problem.signatures:
            found[signature.effect] = found.get(signature.effect, frozenset()) | members(signature)
        return found

    def why_unseen(self, effect: str) -> str:
        """Why this experiment says nothing of an effect; empty where it does."""
        if effect in self.untested:
            return self.untested[effect]
        for item in self.found.problem.excluded:
            if item.effect == effect:
                return item.reason
        rows = [r for r in self.found.rounds[0].effects if r.signature.effect == effect]
        if not rows:
            given = any(link.effect.name == effect for link in self.found.case.chain.links)
            here = "already in the calibration that it starts from"
            return here if given else "no effect on this experiment"
        row = rows[0]
        return row.reason if row.status is EffectStatus.NOT_TESTABLE else ""

    def columns(self, cause: JointCause) -> list[int]:
        """The candidate of each group in the shape that is nearest; −1 where none acts here."""
        here = self.units.get(cause.effect, frozenset())
        return [self._column(cause, group & here) for group in cause.groups]

    def _column(self, cause: JointCause, group: frozenset[str]) -> int:
        mine = [
            i
            for i, s in enumerate(self.found.problem.signatures)
            if group
            and (s.effect, s.parameter) == (cause.effect, cause.parameter)
            and members(s) == group
        ]
        if not mine:
            return -1
        signatures = self.found.problem.signatures
        return min(mine, key=lambda i: _far(cause.shape, signatures[i].shape))

    def sizes(
        self, cause: JointCause, beside: Sequence[JointCause] = ()
    ) -> tuple[SizeSeen | None, ...]:
        """The size of each group beside the calibration, the other groups and other causes."""
        grams = self.grams
        own = self.columns(cause)
        others = [c for other in beside for c in self.columns(other) if c >= 0 and c not in own]
        found: list[SizeSeen | None] = []
        for column in own:
            if column < 0 or self.why_unseen(cause.effect):
                found.append(None)
                continue
            rest = [c for c in own if c >= 0 and c != column] + others
            base = np.concatenate([grams.calibration, grams.candidates[_unique(rest)]])
            found.append(_size_seen(grams, base, grams.candidates[[column]]))
        return tuple(found)

    def gain(self, cause: JointCause, beside: Sequence[JointCause] = ()) -> float:
        """Drop of the squared error, in units of the noise, with all sizes of a cause fitted."""
        grams = self.grams
        own = [c for c in self.columns(cause) if c >= 0]
        others = [c for other in beside for c in self.columns(other) if c >= 0 and c not in own]
        before = np.concatenate([grams.calibration, grams.candidates[_unique(others)]])
        after = np.concatenate([before, grams.candidates[_unique(own)]])
        return _left(grams, before) - _left(grams, after)


def _left(grams: Grams, base: IntArray) -> float:
    """Squared error that a base leaves, in units of the noise."""
    total = grams.inner.summed(np.append(base, grams.inner.last))
    fitted, last = np.arange(base.size), base.size
    gamma = coefficients(total, fitted, np.array([last]))[:, 0]
    return float(total[last, last] - gamma @ total[fitted, last])


def _unique(columns: Sequence[int]) -> IntArray:
    return np.unique(np.array(columns, dtype=np.int64))


def members(signature: Signature) -> frozenset[str]:
    """Who carries a signature."""
    return frozenset(unit for _, units in signature.owners for unit in units)


def _far(wanted: tuple[tuple[str, float], ...], shape: tuple[tuple[str, float], ...]) -> float:
    """Distance of shapes as ratios."""
    here = dict(shape)
    pairs = [(value, here[name]) for name, value in wanted if name in here]
    return float(sum(abs(np.log(_positive(a) / _positive(b))) for a, b in pairs))


def _positive(value: float) -> float:
    return max(abs(value), _SHORT)


def _size_seen(grams: Grams, base: IntArray, column: IntArray) -> SizeSeen | None:
    """Size of one column beside a base; its sd by the noise or by the scatter over blocks.

    The scatter ``Σ_b (s_b − β w_b)²/W²`` with scores s and information w, ``W = Σ w``, holds what
    the noise law leaves out; the larger of both counts.
    """
    found = scores(grams.inner, base, column)
    if found.inside[0]:
        return None
    score, information = found.score[:, 0], found.information[:, 0]
    whole = float(information.sum())
    size = float(score.sum()) / whole
    blocks = float(effective_blocks(information[:, None])[0])
    left = score - size * information
    correction = blocks / max(blocks - 1.0, 0.5)
    variance = max(1.0 / whole, correction * float(left @ left) / whole**2)
    return SizeSeen(size, float(np.sqrt(variance)), max(blocks - 1.0, 1.0))
