"""What every effect must keep, checked on a log where everything moves."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from footcal_cli.core.effects.calibration import AXES
from footcal_cli.core.effects.contract import Effect, can_carry, units_of
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import FloatArray

_ROWS, _RATE_HZ = 600, 40.0
_CELLS = tuple(f"{foot}_{cell}" for foot in ("left", "right") for cell in ("fl", "fr", "rl", "rr"))
_LEGS = ("fl", "ml")
_SEAM = 217
_NOTHING, _SOMETHING = 1e-12, 1e-6
_STEPS = (1e-2, 1e-3)
_ROUGH = 0.05


@dataclass(frozen=True)
class Promise:
    """One promise of an effect: what it is, and what was found; `kept` where it holds."""

    says: str
    found: str
    kept: bool


def promises_of(effect: Effect) -> tuple[Promise, ...]:
    """Neutral does nothing, usual does something, remove undoes apply, chunks equal the whole.

    The derivative by the size is asked for too: at two steps it must be the same.
    """
    log = _log(effect)
    units = len(units_of(effect.scope, log.channels))
    neutral = _theta(effect, units, 0.0)
    usual = _theta(effect, units, 1.0)
    still = max(_apart(log, f(log, neutral, None)[0]) for f in (effect.apply, effect.remove))
    shown, _ = effect.apply(log, usual, None)
    moved = _apart(log, shown)
    back = _apart(log, effect.remove(shown, usual, None)[0])
    seam = max(_at_a_seam(effect, log, usual, name) for name in ("apply", "remove"))
    slopes = [
        (effect.apply(log, _theta(effect, units, step), None)[0].readings - log.readings) / step
        for step in _STEPS
    ]
    scale = max(float(np.abs(slopes[1]).max(initial=0.0)), 1e-300)
    bend = float(np.abs(slopes[0] - slopes[1]).max(initial=0.0)) / scale
    return (
        Promise("absent, it changes nothing", f"{still:.1e}", still < _NOTHING),
        Promise("at its usual size it changes something", f"{moved:.1e}", moved > _SOMETHING),
        Promise("removing it undoes it", f"error {back:.1e}", back <= effect.tolerance),
        Promise("chunk by chunk equals the whole", f"difference {seam:.1e}", seam < 1e-10),
        Promise("it has a derivative by its size", f"differs by {bend:.1e}", bend < _ROUGH),
    )


def _theta(effect: Effect, units: int, share: float) -> dict[str, FloatArray]:
    """Sizes as a share of the usual ones, shapes as they are."""
    theta = {}
    for p in effect.parameters:
        value = p.neutral if p.shape else p.neutral + share * p.prior_sd
        theta[p.name] = np.full(units, float(np.clip(value, p.lower, p.upper)))
    return theta


def _at_a_seam(effect: Effect, log: Log, theta: Mapping[str, FloatArray], way: str) -> float:
    transform = effect.apply if way == "apply" else effect.remove
    whole, _ = transform(log, theta, None)
    first, state = transform(log.rows(0, _SEAM), theta, None)
    second, _ = transform(log.rows(_SEAM, len(log)), theta, state)
    both = np.concatenate([first.readings, second.readings])
    return float(np.abs(both - whole.readings).max(initial=0.0))


def _apart(a: Log, b: Log) -> float:
    """Largest difference of two logs over the largest value, readings and known alike."""
    pairs = [(a.readings, b.readings), *((a.known[k], b.known[k]) for k in a.known)]
    return max(
        float(np.nanmax(np.abs(x - y), initial=0.0)) / max(float(np.nanmax(np.abs(x))), 1e-300)
        for x, y in pairs
    )


def _log(effect: Effect) -> Log:
    """Cells of two feet, or two transducers where only these can carry the effect."""
    on_hips = set(effect.experiments) <= {"hang", "pose"} or not can_carry(_CELLS, effect)
    rng = np.random.default_rng(3)
    time_s = np.arange(_ROWS) / _RATE_HZ
    phases = rng.uniform(0.0, 2.0 * np.pi, (64, 3))
    rates = rng.uniform(0.05, 0.6, (64, 3))
    signals = np.sin(2.0 * np.pi * rates * time_s[:, None, None] + phases).mean(axis=2)
    if on_hips:
        channels = tuple(f"{leg}.{axis}" for leg in _LEGS for axis in AXES)
        readings = np.tile([10.0, 10.0, 20.0, 1.0, 1.0, 1.0], len(_LEGS)) * signals[:, :12]
    else:
        channels = _CELLS
        readings = 6.0 + 5.0 * signals[:, :8]
    cells = len(_CELLS)
    known = {
        "load_n": readings.copy(),
        "temperature_degc": 25.0 + 8.0 * signals[:, 20],
        "com_m": np.array([0.0, 0.0, 0.26]) + 0.05 * signals[:, 21:24],
        "com_acc_mps2": signals[:, 24:27],
        "mass_kg": np.full(_ROWS, 5.3),
        "gravity_mps2": np.full(_ROWS, 9.80665),
        "cell_pos_m": 0.05 * signals[:, 30 : 30 + 2 * cells].reshape(_ROWS, cells, 2),
        "contact": np.ones((_ROWS, 2)),
        "phase_rad": np.pi * signals[:, 50:52],
    }
    blocks = np.arange(_ROWS) // 100
    return Log(effect.experiments[0], channels, time_s, readings, known, blocks)
