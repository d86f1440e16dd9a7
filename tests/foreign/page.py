"""The page of the campaign: coverage, sizes of errors and verdicts, robot by robot."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from scipy import stats

from tests.foreign.kinds import FLEET

Answer = Mapping[str, Any]
Answers = Mapping[tuple[str, int], Answer]
"""Task and robot -> its answer."""

_UNITS = {
    "scale": (100.0, "%"), "zero": (1.0, "N"), "weight": (1.0, "N"), "force offset": (1.0, "N"),
    "torque offset": (1.0, "Nm"), "leg CoM": (1e3, "mm"), "turn": (180.0 / np.pi, "°"),
    "shift": (1e3, "mm"),
}  # fmt: skip
_SURE = 5.0
_ENOUGH = 4
_HEAD = """# Calibrations in a foreign world

{count} of {fleet} robots, estimators and rigs of `tests/foreign`, which share no code with
footcal: bipeds of 1 to 90 kg on three, four or six cells or six-axis ankles,
and robots on four, six and eight legs (`tests/foreign/kinds.py` has them all). Each
command ran as its user runs it
(`make foreign-calibration` makes this page anew). All of them have what ordinary robots have:
quantised encoders, differentiated velocities, a millisecond of stamp lag, part of the angular
momentum missing, masses of links 2 % off, an IMU that leans by milliradians, plates under the
cells, soles that roll, noise that drifts.

*Held* is the share of 95 % intervals that hold the truth, with its own 95 % interval over the
robots; *error / sd* is the root mean square, 1 where the stated sd is right. This table leaves out
the robots whose stated mass is wrong on purpose; they stand in the second one.

"""
_LINES = (
    "| command | quantity | robots | error (RMS) | stated sd | error / sd | held |",
    "|---|---|---|---|---|---|---|",
)
_ROBOTS = """
## Robot by robot

*Worst* is the largest error in units of its stated sd. A value more than five sd off under the
verdict "good" is **sure and wrong**: {sure} of {runs} runs.

| robot | command | exit | verdict | error / sd | worst |
|---|---|---|---|---|---|
"""


def page_of(answers: Answers) -> str:
    """Markdown of all answers."""
    tasks = list(dict.fromkeys(task for task, _ in answers))
    robots = list(dict.fromkeys(seed for _, seed in answers))
    text = _HEAD.format(count=len(robots), fleet=len(FLEET)) + "\n".join(_LINES) + "\n"
    for task in tasks:
        right = [s for s in robots if not FLEET[s].mass_off]
        text += _pooled(task, [answers[task, s] for s in right if (task, s) in answers])
    text += _ROBOTS.format(sure=sum(map(_sure_and_wrong, answers.values())), runs=len(answers))
    for (task, seed), one in sorted(answers.items(), key=lambda item: item[0][1]):
        sizes = ", ".join(
            f"{name} {_rms_ratio(pairs):.2g}" for name, pairs in one["ratios"].items() if pairs
        )
        worst = f"{_worst(one):.1f}" if one["ratios"] else "–"
        mark = " **sure and wrong**" if _sure_and_wrong(one) else ""
        text += (
            f"| {FLEET[seed].name} | {task} | {one['code']} | {one.get('level', '–')} | "
            f"{sizes or '–'} | {worst}{mark} |\n"
        )
    return text + _NOTES


def _pooled(task: str, each: Sequence[Answer]) -> str:
    """Rows of one command: its quantities over all robots."""
    lines = ""
    for name in dict.fromkeys(name for one in each for name in one["ratios"]):
        pairs = [np.array(one["ratios"][name]) for one in each if one["ratios"].get(name)]
        error, sd = (np.concatenate([pair[:, i] for pair in pairs]) for i in (0, 1))
        factor, unit = _UNITS[name]
        lines += (
            f"| {task} | {name} | {len(pairs)} | {factor * _rms(error):.3g} {unit} | "
            f"{factor * _rms(sd):.3g} {unit} | {_rms(error / sd):.2f} | {_held(pairs)} |\n"
        )
    return lines


def _held(pairs: Sequence[Any]) -> str:
    """Coverage, with its interval where there are robots enough for one."""
    share = np.array([np.mean(np.abs(p[:, 0]) < 1.96 * p[:, 1]) for p in pairs])
    if share.size < _ENOUGH:
        return f"{100 * share.mean():.0f} %"
    spread = float(share.std(ddof=1) / np.sqrt(share.size))
    reach = float(stats.t.ppf(0.975, share.size - 1)) * spread
    return f"{100 * share.mean():.0f} ± {100 * reach:.0f} %"


def _rms(values: Any) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


def _rms_ratio(pairs: Sequence[Sequence[float]]) -> float:
    return _rms([error / sd for error, sd in pairs])


def _worst(one: Answer) -> float:
    return max((abs(e) / sd for pairs in one["ratios"].values() for e, sd in pairs), default=0.0)


def _sure_and_wrong(one: Answer) -> bool:
    return one.get("level") == "good" and _worst(one) > _SURE


_NOTES = """
What is judged: scales (relative) and forces without load of cells, where they stand at the end of a
walk; a cell that needs more than a scale and a bias (the robot on FSRs) has no scale of its own and
is judged by its verdict alone. Ankles: offsets, scales of the axes (none is off in truth), and
weight and CoM below the transducer against what the recipe says.

What was mended:

- `offline-fit`: the channels of a bench share one law of noise (sessions, slow drift, the weights'
  own errors), found by restricted likelihood of all channels together.
- `hang-calib`: offsets that jump from hold to hold were invisible with four holds ("good", up to
  250 sd off); now they are in the intervals.
- `online-replay`: the offset of the CoM stays among the unknowns; without it scales of left cells
  against right ones were off by up to 3 sd. A log without a rate of angular momentum, and ankles
  that both contradict the stated mass, are a warning.

What remains: the bench of one session and nine rows (toy on three cells) shows nothing of its
drift. Plates that a short swing accelerates are taken for zeros of the cells (the same robot, 12
mN). Axes of ankles along the walk have scales off by the part of the acceleration that the
estimator smooths away (up to 3.5 sd). A mass that is 5 % wrong is said, not mended.
"""
