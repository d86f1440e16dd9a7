"""A spell of a walk unlike all others: what happens once repeats in no block, and no sign tells it.

Of the room of the diagnosis; `footcal_cli.core.diagnosis.investigation` asks before it searches.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from footcal_cli.core.inference.case import Case
from footcal_cli.core.inference.problem import Problem
from footcal_cli.core.parameters import FloatArray, IntArray
from footcal_cli.core.quality import Finding
from footcal_cli.core.signals import means_of

MOST = 5.0
"""So many times the RMS of the usual block is no part of a gait."""
_WINDOW_S = 0.4
_FEWEST = 6  # blocks, of which most tell what is usual
_EXPLAINED = 0.9
"""Share of a spell's squares that a force at one cell explains, of which another leaves more."""
_WORDS = {"fz": "vertical force", "mx": "moment about x", "my": "moment about y"}
_RESTS = 0.1
"""Of what is missing, that a cell reads which carries nothing."""


@dataclass(frozen=True)
class OddSpell:
    """A spell in which the balance is off as never else.

    Parameters
    ----------
    start_s, end_s
        Since the first stamp of its log.
    output, unit, off, usual
        Where it is largest: mean error in the spell, and RMS of the usual block.
    channel
        The one whose force alone explains it; empty where none does.
    silent
        Whether that channel reads no load meanwhile.
    """

    start_s: float
    end_s: float
    output: str
    unit: str
    off: float
    usual: float
    channel: str = ""
    silent: bool = False

    @property
    def finding(self) -> Finding:
        """What the user should know of it; a cell that reads nothing stops a diagnosis."""
        when = f"from {self.start_s:.1f} to {self.end_s:.1f} s"
        much = f"{abs(self.off):.3g} {self.unit}"
        if self.silent:
            return Finding(
                "dead_cell", "alarm", self.channel,
                f"the cell reads no load {when}, while {much} are missing where it stands",
                "check its wires, its plug and its seat; use the log up to there",
            )  # fmt: skip
        where = f", as a force at {self.channel} would be" if self.channel else ""
        return Finding(
            "odd_spell", "warning", self.channel or "log",
            f"{when} the {_WORDS[self.output]} is off by {much}, {self.times:.0f} times the RMS of "
            f"the usual step{where}",
            "see what happened then: a touch, a stumble, a cable, a loose plug; cut it out",
        )  # fmt: skip

    @property
    def times(self) -> float:
        """How large it is beside what is usual."""
        return abs(self.off) / max(self.usual, 1e-300)


def odd_spell(case: Case, problem: Problem) -> OddSpell | None:
    """The spell of a walk on load cells in which the balance is off most, if it is no other's like.

    The RMS error over windows of 0.4 s, output by output, against `MOST` times the median RMS of
    the blocks. A step that is always bad is in every block.
    """
    if not case.drifts or not case.directions or problem.blocks < _FEWEST:
        return None
    totals = [o for o, name in enumerate(problem.outputs) if name in _WORDS]
    found: tuple[float, IntArray, int, float] | None = None
    for o in totals:
        rows = np.flatnonzero(problem.output == o)
        of_block = np.unique(problem.block[rows], return_inverse=True)[1]
        usual = float(np.median(means_of(problem.residual[rows] ** 2, of_block)))
        unit = float(np.mean(problem.noise[rows]))
        floor = usual + (problem.tolerance[o] / unit) ** 2
        width = max(int(_WINDOW_S * problem.rate_hz), 1)
        square = np.convolve(problem.residual[rows] ** 2, np.full(width, 1.0 / width), "same")
        times = float(np.sqrt(square.max() / floor))
        if times > max(MOST, 0.0 if found is None else found[0]):
            found = times, rows[_around(square, MOST**2 * floor)], o, float(np.sqrt(usual)) * unit
    if found is None:
        return None
    _, rows, o, usual_rms = found
    times_s = problem.time_s[rows]
    start = float(case.logs[int(problem.log[rows[0]])].time_s[0])
    unit = float(np.mean(problem.noise[rows]))
    within = (problem.time_s >= times_s[0]) & (problem.time_s <= times_s[-1])
    within &= (problem.log == problem.log[rows[0]]) & np.isin(problem.output, totals)
    channel, silent = _one_channel(case, problem, np.flatnonzero(within))
    return OddSpell(
        float(times_s[0]) - start, float(times_s[-1]) - start, problem.outputs[o],
        problem.units[o], float(np.mean(problem.residual[rows])) * unit,
        usual_rms, channel, silent,
    )  # fmt: skip


def _around(square: FloatArray, least: float) -> IntArray:
    """Rows next to the largest value that are above a limit."""
    at, above = int(np.argmax(square)), square >= least
    before, after = np.flatnonzero(~above[:at]), np.flatnonzero(~above[at:])
    first = int(before[-1]) + 1 if before.size else 0
    return np.arange(first, at + int(after[0]) if after.size else square.size)


def _one_channel(case: Case, problem: Problem, rows: IntArray) -> tuple[str, bool]:
    """The channel whose force explains a spell, free in every sample; whether it reads no load.

    A force f(t) at a cell acts on all outputs in the proportion of its bias column c(t):
    ``Σ_t (c·r)²/(c·c)`` of ``Σ_t r·r``.
    """
    wandering = [way for way in case.directions if not way.lasting]
    biases = [(way, k) for k, way in enumerate(wandering) if way.kind == "bias"]
    if not biases:  # of transducers whose zeros are tracked otherwise
        return "", False
    _, sample = np.unique(problem.time_s[rows], return_inverse=True)
    left = problem.residual[rows]
    whole = float(left @ left)
    shares, forces = [], []
    for way, k in biases:
        c = problem.calibration[rows, k]
        dot, own = np.bincount(sample, c * left), np.bincount(sample, c * c)
        size = np.divide(dot, own, out=np.zeros_like(dot), where=own > 0.0)
        shares.append(float(size @ dot) / whole)
        forces.append(size * max(way.changes.values()))
    best = int(np.argmax(shares))
    left_by = sorted(1.0 - share for share in shares)
    if shares[best] < _EXPLAINED or left_by[1] < 2.0 * left_by[0]:
        return "", False
    name = biases[best][0].channel
    log = case.logs[int(problem.log[rows[0]])]
    truth, _ = case.chain.remove(log, case.values)
    mine = (log.time_s >= problem.time_s[rows[0]]) & (log.time_s <= problem.time_s[rows[-1]])
    reads = float(np.median(np.abs(truth.readings[mine, truth.channels.index(name)])))
    return name, reads < _RESTS * float(np.median(np.abs(forces[best])))
