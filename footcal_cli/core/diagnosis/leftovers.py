"""The signature of what no name explains: where, on what, which way, since when."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from footcal_cli.core.diagnosis.answer import Diagnosis, Verdict
from footcal_cli.core.diagnosis.investigation import Investigation
from footcal_cli.core.diagnosis.material import left_over
from footcal_cli.core.inference.problem import Problem
from footcal_cli.core.parameters import FloatArray, IntArray

BINS = 12
_SHARE = 0.2
"""Another channel is affected too from this share of the strongest channel's dependence on."""
_NEAREST = 3


@dataclass(frozen=True)
class Leftover:
    """The residual, described by its looks.

    Parameters
    ----------
    output
        Where it is largest.
    channels
        Cells or axes that carry it; empty where all do alike.
    driver
        The recorded signal that tells most about it, empty where none does.
    direction
        A verb phrase before the driver's name.
    onset
        When it begins, in words.
    blocks
        Number of blocks in which it repeats.
    nearest
        Effect, place and |cos| with what can be explained, the nearest first.
    """

    output: str
    channels: tuple[str, ...]
    driver: str
    direction: str
    onset: str
    blocks: int
    nearest: tuple[tuple[str, str, float], ...]


def nameless(found: Investigation) -> tuple[Problem, Diagnosis]:
    """Where the nameless is looked at: beside what was named, or all there is if nothing was."""
    if found.verdict is Verdict.UNKNOWN:
        return found.problem, found.rounds[0]
    return found.final, found.rounds[-1]


def leftover_of(found: Investigation) -> Leftover:
    """The signature of what has no name."""
    problem, last = nameless(found)
    detection = last.before
    left = left_over(problem)
    names = [n for n in detection.groups if n in problem.regressors]
    driver = ""
    if names:
        p = {n: float(detection.group_p[detection.groups.index(n)]) for n in names}
        driver = min(names, key=lambda n: (p[n], -_dependence(problem.regressors[n], left)))
        if detection.curve.p < p[driver]:
            driver = detection.curve.name
    signal = problem.regressors[driver] if driver else np.zeros_like(left)
    output = _strongest(problem.output, signal, left)
    mine = problem.output == output
    labels = _labels(found)
    ceiling = max(detection.ceiling, 1e-9)
    nearest = tuple(
        (r.signature.effect, r.signature.where, float(np.sqrt(np.clip(r.gain / ceiling, 0.0, 1.0))))
        for r in last.effects[:_NEAREST]
        if r.gain > 0
    )
    return Leftover(
        output=problem.outputs[output],
        channels=_touched(labels[mine], signal[mine], left[mine]),
        driver=driver,
        direction="repeats with the" if "phase" in driver else _direction(signal[mine], left[mine]),
        onset=_onset(detection.flexible_gain),
        blocks=int(np.sum(detection.flexible_gain > 0)),
        nearest=nearest,
    )


def _labels(found: Investigation) -> np.ndarray:
    """Channel or output of each row as its experiment names it, shape (m,)."""
    rows = found.problem
    labels = np.empty(rows.residual.size, dtype=object)
    for i, log in enumerate(found.case.logs):
        truth, _ = found.case.chain.remove(log.rows(0, 2), found.case.values)
        outputs = np.array(found.case.experiment.balance(truth).outputs, dtype=object)
        here = rows.log == i
        labels[here] = outputs[rows.column[here]]
    return labels


def _binned(signal: FloatArray, left: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Middle, mean and count of each of a dozen bins of a signal."""
    edges = np.unique(np.quantile(signal, np.linspace(0.0, 1.0, BINS + 1)))
    at = np.clip(np.searchsorted(edges, signal, side="right") - 1, 0, max(edges.size - 2, 0))
    count = np.bincount(at).astype(float)
    filled = count > 0
    middle = np.bincount(at, weights=signal)[filled] / count[filled]
    return middle, np.bincount(at, weights=left)[filled] / count[filled], count[filled]


def _dependence(signal: FloatArray, left: FloatArray) -> float:
    """Squared error that the means over bins of a signal carry, chance taken off."""
    if left.size < 2 * BINS:
        return 0.0
    _, mean, count = _binned(signal, left)
    return float(np.sum(count * mean**2) - count.size * np.var(left))


def _strongest(output: IntArray, signal: FloatArray, left: FloatArray) -> int:
    scores = [
        _dependence(signal[output == o], left[output == o]) for o in range(int(output.max()) + 1)
    ]
    return int(np.argmax(scores))


def _touched(labels: np.ndarray, signal: FloatArray, left: FloatArray) -> tuple[str, ...]:
    """Labels whose dependence is a good part of the strongest one's; none where all are alike."""
    names = list(dict.fromkeys(labels))
    if len(names) < 2:
        return ()
    score = np.array([_dependence(signal[labels == n], left[labels == n]) for n in names])
    touched = score > _SHARE * max(float(score.max()), 0.0)
    if touched.all() or not (score > 0).any():
        return ()
    return tuple(str(n) for n, yes in zip(names, touched, strict=True) if yes)


def _direction(signal: FloatArray, left: FloatArray) -> str:
    if signal.size == 0 or np.ptp(signal) == 0:
        return "depends on"
    middle, mean, count = _binned(signal, left)
    x = (middle - np.average(middle, weights=count)) / max(float(np.std(middle)), 1e-300)
    line = float(np.average(x * mean, weights=count)) * x
    centred = mean - np.average(mean, weights=count)
    straight = np.sum(line * centred) > 0.6 * np.sum(centred**2)
    if not straight:
        return "bends with"
    return "grows with" if np.average(x * mean, weights=count) > 0 else "falls with"


def _onset(gain: FloatArray) -> str:
    """Where along the blocks the explained part sets in."""
    total = float(np.clip(gain, 0.0, None).sum())
    if total <= 0:
        return "–"
    reached = np.cumsum(np.clip(gain, 0.0, None)) / total
    expected = (np.arange(gain.size) + 1.0) / gain.size
    late = int(np.argmax(expected - reached))
    if (expected - reached)[late] > 0.35 and reached[late] < 0.15:
        return f"after block {late + 1} of {gain.size}"
    early = int(np.argmax(reached - expected))
    if (reached - expected)[early] > 0.35 and reached[early] > 0.85:
        return f"from the start, gone after block {early + 1} of {gain.size}"
    return "from the start, throughout"
