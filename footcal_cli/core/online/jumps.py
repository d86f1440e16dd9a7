"""Jumps of a bias, found while filtering: when, which cell, how large.

Generalised likelihood ratio (Willsky and Jones, IEEE Transactions on Automatic Control 21, 1976):
for every onset in the last seconds and every bias, the innovations that a unit jump would have
caused are carried along; the jump whose signature explains the innovations best is believed when
twice its log likelihood ratio exceeds a threshold.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from footcal_cli.core.inference.kalman import Innovation
from footcal_cli.core.online.noise import Guards
from footcal_cli.core.online.rows import Rows
from footcal_cli.core.parameters import FloatArray, IntArray

_TORQUE = 0.1
"""Smallest jump of a torque in Nm, over that of a force in N."""


SURE_SD = 3.0
"""Sizes within so many sd of zero may be no jump at all."""
WRONG_PRIOR = 10.0
"""So many sd may a bias be off what was believed of it before the walk. Of that the share ``P`` is
left where the filter's variance is P in units of the prior's; no smaller change is a jump."""


@dataclass(frozen=True)
class BiasJump:
    """A bias that left its interval at once.

    Parameters
    ----------
    onset_s, found_s
        Stamp of the first update that shows it, and of the update that proved it.
    size, sd
        In the parameter's unit.
    evidence
        Twice the log likelihood ratio.
    least
        Smaller changes are no jump, in the parameter's unit.
    """

    name: str
    onset_s: float
    found_s: float
    size: float
    sd: float
    evidence: float
    least: float = 0.0

    @property
    def refuted(self) -> bool:
        """Whether it is surely smaller than what counts as a jump."""
        return abs(self.size) + SURE_SD * self.sd < self.least

    @property
    def sure(self) -> bool:
        """Whether its size is known well enough for an alarm."""
        return abs(self.size) > SURE_SD * self.sd


@dataclass
class JumpBank:
    """Hypotheses (onset, bias) of the last seconds.

    Parameters
    ----------
    response
        Deviation of truth from filter that a unit jump leaves, shape (s, onsets, biases).
    score, information
        Running sums of signature against innovations, shape (onsets, biases).
    onset
        Update of each hypothesis, −1 while empty.
    unlearnt
        Variance of each bias before its onset, in units of its prior's, shape (onsets, biases).
    least
        Smaller jumps are left to the random walk, in each bias's unit, shape (biases,).
    """

    rows: Rows
    biases: IntArray
    response: FloatArray
    score: FloatArray
    information: FloatArray
    onset: IntArray
    unlearnt: FloatArray
    threshold: float
    least: FloatArray
    found: list[BiasJump] = field(default_factory=list)
    earlier_s: FloatArray = field(default_factory=lambda: np.zeros(0))
    """Stamps of the updates before `rows`, the last one last."""

    @classmethod
    def start(cls, rows: Rows, states: int, guards: Guards) -> JumpBank | None:
        """An empty bank; None where no jump is looked for."""
        biases = np.array(
            [i for i, n in enumerate(rows.names) if n.endswith(".bias") or ".offset_" in n]
        )
        if not np.isfinite(guards.jump_threshold) or not biases.size or len(rows) < 2:
            return None
        interval = float(np.median(np.diff(rows.time_s)))
        size = max(round(guards.jump_memory_s / interval), 1)
        return cls(
            rows,
            biases,
            np.zeros((states, size, biases.size)),
            np.zeros((size, biases.size)),
            np.zeros((size, biases.size)),
            np.full(size, -1),
            np.ones((size, biases.size)),
            guards.jump_threshold,
            guards.least_jump_n
            * np.array([_TORQUE if rows.units[i] == "Nm" else 1.0 for i in biases]),
        )

    def moved_on(self, rows: Rows) -> JumpBank:
        """The bank at the start of rows that follow its own; it has found nothing yet."""
        passed, size = len(self.rows), self.onset.size
        turn = -(passed % size)
        return replace(
            self,
            rows=rows,
            response=np.roll(self.response, turn, axis=1),
            score=np.roll(self.score, turn, axis=0),
            information=np.roll(self.information, turn, axis=0),
            onset=np.roll(self.onset, turn) - passed,
            unlearnt=np.roll(self.unlearnt, turn, axis=0),
            found=[],
            earlier_s=np.concatenate([self.earlier_s, self.rows.time_s])[-size:],
        )

    def _stamp(self, update: int) -> float:
        times = self.rows.time_s if update >= 0 else self.earlier_s
        return float(times[update])

    def update(
        self,
        j: int,
        h: FloatArray,
        found: Innovation,
        decay: FloatArray,
        mean: FloatArray,
        cov: FloatArray,
    ) -> tuple[FloatArray, FloatArray]:
        """Take in update j of the filter; correct its state where a jump is proved."""
        s, size, count = self.response.shape
        slot = j % size
        self.response *= decay[:, None, None]
        self.response[:, slot] = 0.0
        self.response[self.biases, slot, np.arange(count)] = 1.0
        self.score[slot] = self.information[slot] = 0.0
        self.onset[slot] = j
        corrected = np.sum(found.weight[:, self.biases] ** 2, axis=0)
        self.unlearnt[slot] = cov[self.biases, self.biases] + corrected
        flat = self.response.reshape(s, -1)
        whitened = found.root @ (h @ flat)
        self.score += (found.standard @ whitened).reshape(size, count)
        self.information += np.sum(whitened**2, axis=0).reshape(size, count)
        flat -= found.weight.T @ whitened
        evidence = self.score**2 / np.maximum(self.information, 1e-12)
        wrong = np.abs(self.score) < WRONG_PRIOR * self.unlearnt * self.information
        evidence[wrong] = 0.0
        best = np.unravel_index(int(np.argmax(evidence)), evidence.shape)
        if evidence[best] <= self.threshold:
            return mean, cov
        index = int(self.biases[best[1]])
        size_z = float(self.score[best] / self.information[best])
        variance = float(1.0 / self.information[best])
        if abs(size_z) * self.rows.prior_sd[index] < self.least[best[1]]:
            return mean, cov
        onset = int(self.onset[best[0]])
        self.believe(int(best[1]), onset, j, size_z, variance, float(evidence[best]))
        left = self.response[:, best[0], best[1]].copy()
        self.response[:] = 0.0
        self.score[:] = self.information[:] = 0.0
        return mean + left * size_z, cov + np.outer(left, left) * variance

    def believe(
        self, which: int, onset: int, proof: int, size_z: float, variance: float, evidence: float
    ) -> None:
        """Keep a jump of the `which`-th bias, size and variance in units of its prior sd."""
        index = int(self.biases[which])
        unit = float(self.rows.prior_sd[index])
        self.found.append(
            BiasJump(
                name=self.rows.names[index],
                onset_s=self._stamp(onset),
                found_s=self._stamp(proof),
                size=size_z * unit,
                sd=float(np.sqrt(variance)) * unit,
                evidence=evidence,
                least=float(self.least[which]),
            )
        )
