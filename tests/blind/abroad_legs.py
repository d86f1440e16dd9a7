"""Causes hidden in the six-axis logs of the foreign world: legs that hang, and legs in poses."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pandas as pd

from tests.blind.classes import FLIPS
from tests.blind.world import Rng
from tests.foreign import Recorded, hang, joined, poses

Hide = Callable[[int, Rng], Recorded]


def with_log(recorded: Recorded, role: str, table: pd.DataFrame) -> Recorded:
    return replace(recorded, logs={**recorded.logs, role: table})


def heavier(recorded: Recorded, share: float) -> Recorded:
    robot = {**recorded.robot, "mass_kg": recorded.robot["mass_kg"] * (1.0 + share)}
    return replace(recorded, robot=robot)


def _legs(seed: int, role: str) -> Recorded:
    short = hang(seed, turns=6.3, turn_s=8.0, rate_hz=20.0)
    return short if role == "hang" else joined(poses(seed), short)


def _on_leg(
    seed: int, role: str, rng: Rng, change: Callable[[pd.DataFrame, Rng], pd.DataFrame]
) -> Recorded:
    """Something wrong with one leg of a log."""
    recorded = _legs(seed, role)
    table = recorded.logs[role].copy()
    mine = table["leg"] == str(rng.choice(["fl", "ml", "hl", "fr", "mr", "hr"]))
    table.loc[mine] = change(table.loc[mine].copy(), rng)
    return with_log(recorded, role, table)


def _coupled(leg: pd.DataFrame, rng: Rng) -> pd.DataFrame:
    leg["fy_n"] += 0.04 * leg["fx_n"]
    leg["fx_n"] -= 0.03 * leg["fz_n"]
    return leg


def _dragged(leg: pd.DataFrame, rng: Rng) -> pd.DataFrame:
    phase = leg["phase_rad"].to_numpy() + rng.uniform(0, 6)
    leg["fx_n"] += 0.5 * np.sin(phase) + 0.08 * np.sin(2 * phase)
    leg["fz_n"] += 0.3 * np.cos(phase)
    return leg


def _drifting(leg: pd.DataFrame, rng: Rng) -> pd.DataFrame:
    time_s = leg["time_s"].to_numpy()
    leg["fz_n"] += 0.5 * np.sqrt((time_s - time_s.min()) / np.ptp(time_s))
    return leg


def _half_turned(leg: pd.DataFrame, rng: Rng) -> pd.DataFrame:
    """A transducer mounted the other way round about its own axis."""
    across = [str(c) for c in leg if str(c).startswith(("fx", "fy", "tx", "ty"))]
    leg[across] *= -1.0
    return leg


def _moving_away(leg: pd.DataFrame, rng: Rng) -> pd.DataFrame:
    """An offset that creeps from pose to pose."""
    leg["fz_n"] += 0.8 * np.sqrt(np.linspace(0.0, 1.0, len(leg)))
    return leg


def _bent_leg(leg: pd.DataFrame, rng: Rng) -> pd.DataFrame:
    force = leg["fz_n"].to_numpy()
    leg["fz_n"] = force + 0.04 * np.abs(force).max() * np.expm1(-np.abs(force) / 2.0)
    return leg


def _loose(leg: pd.DataFrame, rng: Rng) -> pd.DataFrame:
    """A wire that loses 60 % of one axis for 5 to 30 samples, once in some hundred."""
    away = np.zeros(len(leg), dtype=bool)
    for start in rng.choice(len(leg), size=max(len(leg) // 300, 6), replace=False):
        away[start : start + rng.integers(5, 31)] = True
    axis = str(rng.choice(["fx_n", "fy_n", "fz_n"]))
    leg.loc[away, axis] *= 0.4
    return leg


def _fast(seed: int) -> Recorded:
    """Legs that turn in two seconds: what accelerates them shows."""
    return hang(seed, turns=12.3, turn_s=2.0, rate_hz=50.0)


def _hung_then(recorded: Recorded, seed: int) -> Recorded:
    return joined(recorded, hang(seed, turns=6.3, turn_s=8.0, rate_hz=20.0))


def _swapped_legs(seed: int, rng: Rng) -> Recorded:
    recorded = _legs(seed, "poses")
    table = recorded.logs["poses"].copy()
    names = {"fl": "ml", "ml": "fl"}
    axes = [str(c) for c in table if str(c).startswith(("fx", "fy", "fz", "tx", "ty", "tz"))]
    shown = table.set_index(["pose", "leg"])[axes]
    other = [(p, names.get(k, k)) for p, k in zip(table["pose"], table["leg"], strict=True)]
    table[axes] = shown.loc[other].to_numpy()
    return with_log(recorded, "poses", table)


def _leg(role: str, change: Callable[[pd.DataFrame, Rng], pd.DataFrame]) -> Hide:
    return lambda seed, rng: _on_leg(seed, role, rng, change)


ON_LEGS: tuple[tuple[str, str, tuple[str, ...], Hide], ...] = (
    ("hang", "", (), lambda s, r: _legs(s, "hang")),
    ("hang", "clean, fast", (), lambda s, r: _fast(s)),
    ("hang", "half turn", FLIPS, _leg("hang", _half_turned)),
    ("hang", "curve", ("nonlinearity", "dead_zone", "hinge"), _leg("hang", _bent_leg)),
    ("hang", "coupling", ("cross_coupling",), _leg("hang", _coupled)),
    ("hang", "cable", ("cable_drag",), _leg("hang", _dragged)),
    ("hang", "drift", ("offset_drift",), _leg("hang", _drifting)),
    ("hang", "loose contact", ("loose contact",), _leg("hang", _loose)),
    ("pose", "", (), lambda s, r: _legs(s, "poses")),
    ("pose", "mass", ("robot_weight",), lambda s, r: _hung_then(heavier(poses(s), 0.04), s)),
    ("pose", "half turn", FLIPS, _leg("poses", _half_turned)),
    ("pose", "drift", ("offset_drift", "offset_change"), _leg("poses", _moving_away)),
    ("pose", "coupling", ("cross_coupling",), _leg("poses", _coupled)),
    ("pose", "cable", ("cable_drag",), _leg("poses", _dragged)),
    ("pose", "plugs", ("channel_swap",), _swapped_legs),
)
