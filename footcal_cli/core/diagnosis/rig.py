"""What planned experiments start from: the robot at hand, its loads and its noise."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from footcal_cli.core.effects.contract import is_six_axis
from footcal_cli.core.experiments.walk import CELL_TOTALS
from footcal_cli.core.inference.case import Case
from footcal_cli.core.inference.problem import Problem
from footcal_cli.core.log import EXPERIMENT_NAMES, Log
from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.simulation.robots import Biped, Hexapod, leg_at

MOVING_MPS2 = 0.05
"""Noise of the CoM's acceleration while a small robot moves, after the low-pass."""
_LEVER_M = 0.1
"""Turns the noise of a force into that of a moment where no moment was measured."""


@dataclass(frozen=True)
class Rig:
    """Where a planned experiment would take place.

    Parameters
    ----------
    biped, hexapod
        Robots whose channels are those of the data.
    full_load_n
        Largest weight for single cells.
    noise_n
        Noise sd of one channel.
    noise
        Noise sd of the outputs that the data know, in their units.
    moving_mps2
        Noise sd of the CoM's acceleration, where the data are of a robot that stood still: a
        motion's balance has it beside `noise`.
    independent_hz
        Rate at which noise renews itself; infinite where it is white.
    kinds
        Experiments that can be done here.
    """

    biped: Biped = field(default_factory=Biped)
    hexapod: Hexapod = field(default_factory=Hexapod)
    full_load_n: float = 30.0
    noise_n: float = 0.03
    noise: Mapping[str, float] = field(default_factory=dict)
    moving_mps2: float = 0.0
    independent_hz: float = np.inf
    kinds: tuple[str, ...] = EXPERIMENT_NAMES

    def noise_of(self, output: str, unit: str, kind: str = "") -> float:
        """Noise sd of an output in its unit; feet and legs share theirs."""
        plain = output.rsplit(".", 1)[-1]
        found = self.noise.get(output, self.noise.get(plain))
        if found is None:
            found = self.noise_n * (_LEVER_M if unit == "Nm" else 1.0)
        if kind == "walk" and plain in CELL_TOTALS:
            arm = self.biped.com_height_m if unit == "Nm" else 1.0
            found = float(np.hypot(found, self.biped.mass_kg * self.moving_mps2 * arm))
        return found


def rig_of(case: Case, problem: Problem, autocorrelation_time: float) -> Rig:
    """The rig of a diagnosed recording.

    Parameters
    ----------
    autocorrelation_time
        Of its residual, in rows.
    """
    noise = {}
    for o, name in enumerate(problem.outputs):
        rows = problem.output == o
        if rows.any():
            noise[name] = float(np.median(problem.noise[rows]))
    forces = [noise[n] for n, u in zip(problem.outputs, problem.units, strict=True)
              if u == "N" and n in noise]  # fmt: skip
    tau = max(autocorrelation_time, 1.0)
    rig = Rig(
        noise_n=min(forces, default=0.03),
        noise=noise,
        moving_mps2=MOVING_MPS2 if case.experiment.name == "stand" else 0.0,
        independent_hz=problem.rate_hz / tau if problem.rate_hz > 0 else np.inf,
        kinds=_feasible(case),
    )
    log = case.logs[0]
    channels = tuple(dict.fromkeys(c for log in case.logs for c in log.channels))
    if is_six_axis(channels):
        return replace(rig, hexapod=_hexapod(channels, case.logs))
    biped = _biped(channels, log)
    return replace(rig, biped=biped, full_load_n=_full_load_n(case, biped))


def _feasible(case: Case) -> tuple[str, ...]:
    """Experiments that whoever made this one can do too."""
    kind = case.experiment.name
    if kind in ("hang", "pose"):
        return ("hang", "pose")
    if is_six_axis(case.logs[0].channels):
        return ()
    cells = ("weights", "placements", "stand", "walk")
    return cells[: cells.index(kind) + 1] if kind in cells[:2] else cells


def _full_load_n(case: Case, biped: Biped) -> float:
    known = [log.known["load_n"] for log in case.logs if "load_n" in log.known]
    if known:
        return max(float(np.nanmax(np.abs(load))) for load in known)
    return 0.5 * biped.weight_n


def _biped(channels: tuple[str, ...], log: Log) -> Biped:
    """A biped with the cells of the data; what a log does not tell is as usual."""
    usual = Biped()
    where = _cells_in_foot(log)
    feet: dict[str, dict[str, tuple[float, float]]] = {}
    for i, channel in enumerate(channels):
        foot, _, cell = channel.partition("_")
        if where is not None and i < len(where):
            place = (float(where[i, 0]), float(where[i, 1]))
        else:
            corners = list(usual.feet["left"].values())
            place = corners[len(feet.get(foot, ())) % len(corners)]
        feet.setdefault(foot, {})[cell or channel] = place
    if len(feet) != 2 or min(len(cells) for cells in feet.values()) < 3:
        return usual
    found = replace(usual, feet=feet)
    if "mass_kg" in log.known and "com_m" in log.known:
        height = float(np.median(log.known["com_m"][:, 2]))
        found = replace(
            found,
            mass_kg=float(np.median(log.known["mass_kg"])),
            com_height_m=height if np.isfinite(height) else usual.com_height_m,  # insoles: unknown
        )
    return found


def _cells_in_foot(log: Log) -> FloatArray | None:
    """Cell positions about the middle of their foot, in its frame, shape (c, 2)."""
    if "cell_pos_m" not in log.known:
        return None
    first = log.known["cell_pos_m"][0]
    feet = np.array([channel.split("_", 1)[0] for channel in log.channels])
    yaw = log.known.get("foot_yaw_rad")
    out: FloatArray = np.empty_like(first)
    for i, foot in enumerate(dict.fromkeys(feet)):
        mine = feet == foot
        arms = first[mine] - first[mine].mean(axis=0)
        angle = 0.0 if yaw is None else float(yaw[0, i])
        cos, sin = np.cos(angle), np.sin(angle)
        out[mine] = arms @ np.array([[cos, -sin], [sin, cos]])
    return out


def _hexapod(channels: tuple[str, ...], logs: tuple[Log, ...]) -> Hexapod:
    """A hexapod with the legs of the data, where they stand on it."""
    names = tuple(dict.fromkeys(channel.split(".", 1)[0] for channel in channels))
    usual = Hexapod()
    angle = 2.0 * np.pi * (np.arange(len(names)) + 0.5) / max(len(names), 1)
    legs = {}
    for i, name in enumerate(names):
        ring = (0.22 * float(np.cos(angle[i])), 0.16 * float(np.sin(angle[i])), 0.0)
        legs[name] = usual.legs.get(name) or leg_at(name, ring, (0.0, 0.0, 0.0))
    if set(names) < set(usual.legs) or len(legs) < 3:
        return usual
    weight = next((float(log.known["robot_weight_n"][0]) for log in logs
                   if "robot_weight_n" in log.known), usual.weight_n)  # fmt: skip
    return replace(usual, legs=legs, mass_kg=weight / usual.gravity_mps2)
