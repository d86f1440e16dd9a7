"""The page of the campaign: coverage and sizes of errors, before and now."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from scipy import stats

Answers = dict[str, list[dict[str, Any]]]
"""Task -> the answers of all seeds."""
Summary = dict[str, dict[str, Any]]

_UNITS = {
    "scale": (100.0, "%"), "zero": (1.0, "N"), "weight": (1.0, "N"), "force offset": (1e3, "mN"),
    "torque offset": (1e3, "mNm"), "leg CoM": (1e3, "mm"), "turn": (180.0 / np.pi, "°"),
    "shift": (1e3, "mm"),
}  # fmt: skip
_SURE = 5.0
_ENOUGH = 5
_HEAD = """# Calibrations in a foreign world

Robots, estimators and rigs of `tests/foreign` share no code with footcal. Each seed is another
robot; each command ran as its user runs it (`make foreign-calibration` makes this page anew). The
world has what ordinary robots have: quantised encoders, differentiated velocities, a millisecond of
stamp lag, a fifth of the angular momentum missing, masses of links 2 % off, an IMU that leans by
milliradians, 25 g under each cell, soles that roll, noise that drifts. Nothing here was tuned on
these seeds.

*Held* is the share of 95 % intervals that hold the truth, with its own 95 % interval over five
robots or more; *error / sd* is the root mean square, 1 where the stated sd is right. *Sure and
wrong* counts runs with the verdict "good" and a value more than five sd off.

| command | quantity | robots | error (RMS) | stated sd | error / sd | held | held before |
|---|---|---|---|---|---|---|---|
"""


def summary_of(answers: Mapping[str, Sequence[Mapping[str, Any]]]) -> Summary:
    """Errors by task and quantity, verdicts and exit codes."""
    found: Summary = {}
    for task, each in answers.items():
        quantities: dict[str, dict[str, float]] = {}
        names = list(dict.fromkeys(name for one in each for name in one["ratios"]))
        for name in names:
            pairs = [np.array(one["ratios"][name]) for one in each if name in one["ratios"]]
            error, sd = (np.concatenate([pair[:, i] for pair in pairs]) for i in (0, 1))
            share = np.array([np.mean(np.abs(p[:, 0]) < 1.96 * p[:, 1]) for p in pairs])
            spread = float(share.std(ddof=1) / np.sqrt(share.size)) if share.size > 1 else 1.0
            reach = float(stats.t.ppf(0.975, max(share.size - 1, 1))) * spread
            quantities[name] = {
                "robots": len(pairs),
                "rms": float(np.sqrt(np.mean(error**2))),
                "sd": float(np.sqrt(np.mean(sd**2))),
                "ratio": float(np.sqrt(np.mean((error / sd) ** 2))),
                "held": float(share.mean()),
                "reach": reach,
            }
        found[task] = {
            "quantities": quantities,
            "runs": len(each),
            "failed": sum(one["code"] != 0 for one in each),
            "levels": {
                level: sum(one.get("level") == level for one in each)
                for level in ("good", "warning", "bad")
            },
            "sure": sum(_sure_and_wrong(one) for one in each),
        }
    return found


def _sure_and_wrong(one: Mapping[str, Any]) -> bool:
    worst = max(
        (abs(error) / sd for pairs in one["ratios"].values() for error, sd in pairs), default=0.0
    )
    return one.get("level") == "good" and worst > _SURE


def _held(q: Mapping[str, float]) -> str:
    """Coverage, with its interval where there are robots enough for one."""
    reach = f" ± {100 * q['reach']:.0f}" if q["robots"] >= _ENOUGH else ""
    return f"{100 * q['held']:.0f}{reach} %"


def page_of(now: Summary, before: Summary) -> str:
    """The page in Markdown."""
    lines = []
    for task, one in now.items():
        for name, q in one["quantities"].items():
            factor, unit = _UNITS[name]
            old = before.get(task, {}).get("quantities", {}).get(name)
            was = "–" if old is None else f"{100 * old['held']:.0f} % ({old['robots']:.0f})"
            lines.append(
                f"| {task} | {name} | {q['robots']} | {factor * q['rms']:.3g} {unit} | "
                f"{factor * q['sd']:.3g} {unit} | {q['ratio']:.2f} | {_held(q)} | "
                f"{was} |"
            )
    verdicts = [
        "",
        "| command | runs | exit other than 0 | good | warning | bad | sure and wrong | before |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for task, one in now.items():
        level = one["levels"]
        was = f"{before[task]['sure']} of {before[task]['runs']}" if task in before else "–"
        verdicts.append(
            f"| {task} | {one['runs']} | {one['failed']} | {level['good']} | {level['warning']} | "
            f"{level['bad']} | {one['sure']} | {was} |"
        )
    return _HEAD + "\n".join([*lines, *verdicts]) + "\n" + _NOTES


_NOTES = """
*Before* is version 54b3c9a on the first of the same robots (their number in brackets).

What was mended:

- `pose-calib`: noise that lasts from pose to pose (here 30 % of the variance over 8 poses) is found
  by restricted likelihood, a white part and a first-order autoregression; the poses count with the
  inverse of that correlation.
- `online-replay`: the estimator's false accelerations repeat in every step. Where errors repeat,
  total force and moments count up to the frequency of steps alone, and the intervals know that
  what repeats was fitted too.
- `static-init` and `online-replay` keep what a calibration by `offline-fit` knew, instead of
  widening it by all that a data sheet leaves open.

- `offline-fit`: the sd of few sessions is that whose Gaussian interval is as wide as Student's.

What remains: forces without load from four repeats (`offline-fit`, zero) have three degrees of
freedom, and intervals that take them for more. `hang-calib` at 6 s a turn does not know the leg's
product of inertia. `--causal` replays do not limit their band.
"""
