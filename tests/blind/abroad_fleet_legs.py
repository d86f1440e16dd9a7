"""Causes hidden in the six-axis logs of legged robots of many makes, and of a wrist.

`abroad_legs` hides the same causes in the usual hexapod; here sizes go with the robot's weight.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pandas as pd

from tests.blind.abroad_legs import Hide, heavier, with_log
from tests.blind.classes import FLIPS
from tests.blind.world import Rng
from tests.foreign import Recorded, draw_hexapod, hang, joined, poses
from tests.foreign.kinds import DRAW, kind_of
from tests.foreign.legs import AXES
from tests.foreign.wrist import TOOL, wrist

MAKES = (
    7017, 7018, 7019, 7020, 7021, 7022, 7023, 7024, 7102, 7103, 7104, 7105, 7206, 7207, 7208,
)  # fmt: skip
"""Robots of 0.9 to 300 kg on four to ten legs."""
WEIGHED = tuple(make for make in MAKES if not kind_of(make).mass_off)
"""Makes whose stated mass is right."""
WRIST = 7110
TURNS = 6.3
CURVES = ("nonlinearity", "nonlinearity_cubic", "dead_zone", "hinge")
DRIFTS = ("offset_drift", "offset_change")

Change = Callable[[pd.DataFrame, float, Rng], pd.DataFrame]
"""``(rows of one leg, weight in N that sizes go with, rng) -> rows``."""


def maker(seed: int, makes: tuple[int, ...] = MAKES) -> int:
    """A seed that draws a robot of one of the makes."""
    return (seed // len(makes)) * DRAW + makes[seed % len(makes)]


def _hung(seed: int) -> Recorded:
    return hang(maker(seed), turns=TURNS)


def _posed(seed: int, makes: tuple[int, ...] = MAKES) -> Recorded:
    drawn = maker(seed, makes)
    return joined(poses(drawn), hang(drawn, turns=TURNS))


def _on_leg(role: str, change: Change) -> Hide:
    """Something wrong with one leg of a log."""

    def hidden(seed: int, rng: Rng) -> Recorded:
        recorded = _hung(seed) if role == "hang" else _posed(seed)
        robot = draw_hexapod(maker(seed))
        leg = int(rng.integers(len(robot.legs)))
        weight = 9.81 * (robot.leg_kg[leg] if role == "hang" else robot.mass_kg)
        table = recorded.logs[role].copy()
        mine = table["leg"] == robot.legs[leg]
        table.loc[mine] = change(table.loc[mine].copy(), float(weight), rng)
        return with_log(recorded, role, table)

    return hidden


def _coupled(leg: pd.DataFrame, weight: float, rng: Rng) -> pd.DataFrame:
    leg["fy_n"] += 0.04 * leg["fx_n"]
    leg["fx_n"] -= 0.03 * leg["fz_n"]
    return leg


def _dragged(leg: pd.DataFrame, weight: float, rng: Rng) -> pd.DataFrame:
    """A cable that pulls with the shaft's angle, 8 % of a leg's weight."""
    phase = leg["phase_rad"].to_numpy() + rng.uniform(0, 6)
    leg["fx_n"] += weight * (0.08 * np.sin(phase) + 0.013 * np.sin(2 * phase))
    leg["fz_n"] += weight * 0.05 * np.cos(phase)
    return leg


def _dragged_standing(leg: pd.DataFrame, weight: float, rng: Rng) -> pd.DataFrame:
    return _dragged(leg, 0.08 * weight, rng)


def _drifting(leg: pd.DataFrame, weight: float, rng: Rng) -> pd.DataFrame:
    time_s = leg["time_s"].to_numpy()
    leg["fz_n"] += 0.08 * weight * np.sqrt((time_s - time_s.min()) / np.ptp(time_s))
    return leg


def _half_turned(leg: pd.DataFrame, weight: float, rng: Rng) -> pd.DataFrame:
    """A transducer mounted the other way round about its own axis."""
    across = [str(c) for c in leg if str(c).startswith(("fx", "fy", "tx", "ty"))]
    leg[across] *= -1.0
    return leg


def _moving_away(leg: pd.DataFrame, weight: float, rng: Rng) -> pd.DataFrame:
    """An offset that creeps from pose to pose by 2 % of the robot's weight."""
    leg["fz_n"] += 0.02 * weight * np.sqrt(np.linspace(0.0, 1.0, len(leg)))
    return leg


def _bent(leg: pd.DataFrame, weight: float, rng: Rng) -> pd.DataFrame:
    force = np.abs(leg["fz_n"].to_numpy())
    leg["fz_n"] += 0.06 * force.max() * np.expm1(-force / (0.3 * force.max()))
    return leg


def _loose(leg: pd.DataFrame, weight: float, rng: Rng) -> pd.DataFrame:
    """A wire that loses 60 % of one axis for 5 to 30 samples, once in some hundred."""
    away = np.zeros(len(leg), dtype=bool)
    for start in rng.choice(len(leg), size=max(len(leg) // 300, 6), replace=False):
        away[start : start + rng.integers(5, 31)] = True
    leg.loc[away, str(rng.choice(["fx_n", "fy_n", "fz_n"]))] *= 0.4
    return leg


def _heavy(seed: int, rng: Rng) -> Recorded:
    return heavier(_posed(seed, WEIGHED), 0.04)


def _swapped_legs(seed: int, rng: Rng) -> Recorded:
    """The plugs of the two foremost left legs in each other's socket."""
    recorded = _posed(seed)
    table, (first, second) = recorded.logs["poses"].copy(), draw_hexapod(maker(seed)).legs[:2]
    names = {first: second, second: first}
    axes = list(AXES)
    shown = table.set_index(["pose", "leg"])[axes]
    other = [(p, names.get(k, k)) for p, k in zip(table["pose"], table["leg"], strict=True)]
    table[axes] = shown.loc[other].to_numpy()
    return with_log(recorded, "poses", table)


def _held(seed: int) -> tuple[Recorded, float]:
    """A tool that is turned by hand, in the columns that a recipe has; its weight in N."""
    recorded = wrist(seed * DRAW + WRIST)
    raw = recorded.logs["wrist"]
    table = pd.DataFrame({"time_s": raw["t"], "leg": TOOL})
    for axis in AXES:
        table[axis] = raw[f"{TOOL}_{axis.split('_')[0]}"]
    for angle in ("roll", "pitch", "yaw"):
        table[f"body_{angle}_rad"] = np.radians(raw[f"{angle}_deg"])
    logs = {"hang": table}
    return replace(recorded, logs=logs), float(recorded.truth["parameters"][f"{TOOL}.weight"])


def _on_wrist(change: Change) -> Hide:
    def hidden(seed: int, rng: Rng) -> Recorded:
        recorded, weight = _held(seed)
        return with_log(recorded, "hang", change(recorded.logs["hang"], weight, rng))

    return hidden


def _unchanged(table: pd.DataFrame, weight: float, rng: Rng) -> pd.DataFrame:
    return table


def _doubly_coupled(table: pd.DataFrame, weight: float, rng: Rng) -> pd.DataFrame:
    """Twice as much as of a leg: 18 holds under a cable show less."""
    return _coupled(_coupled(table, weight, rng), weight, rng)


def _mirrored(table: pd.DataFrame, weight: float, rng: Rng) -> pd.DataFrame:
    table[str(rng.choice(["fx_n", "fy_n", "fz_n"]))] *= -1.0
    return table


ON_FLEET: tuple[tuple[str, str, tuple[str, ...], Hide], ...] = (
    ("fleet hang", "", (), lambda s, r: _hung(s)),
    ("fleet hang", "half turn", FLIPS, _on_leg("hang", _half_turned)),
    ("fleet hang", "curve", CURVES, _on_leg("hang", _bent)),
    ("fleet hang", "coupling", ("cross_coupling",), _on_leg("hang", _coupled)),
    ("fleet hang", "cable", ("cable_drag",), _on_leg("hang", _dragged)),
    ("fleet hang", "drift", ("offset_drift",), _on_leg("hang", _drifting)),
    ("fleet hang", "loose contact", ("loose contact",), _on_leg("hang", _loose)),
    ("fleet pose", "", (), lambda s, r: _posed(s, WEIGHED)),
    ("fleet pose", "mass", ("robot_weight",), _heavy),
    ("fleet pose", "half turn", FLIPS, _on_leg("poses", _half_turned)),
    ("fleet pose", "drift", DRIFTS, _on_leg("poses", _moving_away)),
    ("fleet pose", "coupling", ("cross_coupling",), _on_leg("poses", _coupled)),
    ("fleet pose", "cable", ("cable_drag",), _on_leg("poses", _dragged_standing)),
    ("fleet pose", "plugs", ("channel_swap",), _swapped_legs),
    ("wrist", "", (), _on_wrist(_unchanged)),
    ("wrist", "coupling", ("cross_coupling",), _on_wrist(_doubly_coupled)),
    ("wrist", "drift", ("offset_drift",), _on_wrist(_drifting)),
    ("wrist", "half turn", FLIPS, _on_wrist(_half_turned)),
    ("wrist", "mirrored", ("axis_flip", "sign_flip"), _on_wrist(_mirrored)),
)
"""Experiment, cause, names that are right, how it is hidden."""
