"""Logs with smooth, everything-moving signals, on which every effect of the table can be tried."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from scipy.spatial.transform import Rotation

from footcal_cli.core.effects.calibration import AXES
from footcal_cli.core.effects.contract import Effect, can_carry
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import FloatArray

CELLS = tuple(f"{foot}_{cell}" for foot in ("left", "right") for cell in ("fl", "fr", "rl", "rr"))
LEGS = ("fl", "ml")
SHAPES = {"saturation_limit": 5.0}
"""Where the table's own shape would not act on these logs."""


def smooth(rng: np.random.Generator, rows: int, *shape: int) -> FloatArray:
    """Sums of five slow sines that start and end at rest, shape (rows, *shape), of order 1."""
    t = np.linspace(0.0, 1.0, rows).reshape(-1, *[1] * (len(shape) + 1))
    cycles = rng.uniform(1.0, 8.0, (*shape, 5))
    phase = rng.uniform(0.0, 2.0 * np.pi, (*shape, 5))
    rest = np.clip(np.minimum(t, 1.0 - t) / 0.1 - 1.0, 0.0, 1.0)[..., 0]
    signal = np.sin(2.0 * np.pi * cycles * t + phase).mean(axis=-1)
    return np.asarray(2.0 * signal * rest**2 * (3.0 - 2.0 * rest))


def cell_log(experiment: str = "walk", rows: int = 1200) -> Log:
    """Eight cells, 30 s at 40 Hz, with everything that any experiment with cells knows."""
    rng = np.random.default_rng(1)
    c = len(CELLS)
    contact = np.ones((rows, 2))
    contact[rows // 3 : rows // 2, 0] = 0.0
    contact[rows // 2 : rows // 2 + 5, 0] = np.nan
    return Log(
        experiment,
        CELLS,
        np.arange(rows) / 40.0,
        6.0 + 5.0 * smooth(rng, rows, c),
        {
            "load_n": 5.0 * np.rint(2.0 + 2.0 * smooth(rng, rows, c)),
            "pieces": np.floor(4.0 * np.arange(rows) / rows),
            "hole_m": 0.05 * smooth(rng, rows, 2),
            "temperature_degc": 25.0 + 8.0 * smooth(rng, rows),
            "com_m": np.array([0.0, 0.0, 0.26]) + 0.05 * smooth(rng, rows, 3),
            "com_acc_mps2": smooth(rng, rows, 3),
            "angmom_rate_nm": smooth(rng, rows, 2),
            "mass_kg": np.full(rows, 5.3),
            "gravity_mps2": np.full(rows, 9.80665),
            "cell_pos_m": 0.1 * smooth(rng, rows, c, 2),
            "foot_yaw_rad": 0.3 * smooth(rng, rows, 2),
            "contact": contact,
        },
        np.arange(rows) // 100,
    )


def six_axis_log(experiment: str = "pose", rows: int = 1200) -> Log:
    """Two legs, with everything that any six-axis experiment knows."""
    rng = np.random.default_rng(2)
    legs = len(LEGS)
    axis = np.eye(3)[[0, 2]][np.arange(rows) * 4 // rows % 2] * np.where(
        np.arange(rows) < rows // 2, 1.0, -1.0
    ).reshape(-1, 1)
    return Log(
        experiment,
        tuple(f"{leg}.{name}" for leg in LEGS for name in AXES),
        np.arange(rows) / 40.0,
        (np.array([10.0, 10.0, 20.0, 1.0, 1.0, 1.0]) * smooth(rng, rows, legs, 6)).reshape(
            rows, -1
        ),
        {
            "phase_rad": np.pi * smooth(rng, rows, legs),
            "gravity_dir": axis,
            "leg_weight_n": np.full((rows, legs), 6.2),
            "leg_com_m": 0.05 * smooth(rng, rows, legs, 3),
            "robot_weight_n": np.full(rows, 80.0),
            "rot_wb": Rotation.from_rotvec(0.1 * smooth(rng, rows, 3)).as_matrix(),
            "temperature_degc": 25.0 + 8.0 * smooth(rng, rows),
            "contact": np.ones((rows, legs)),
        },
        np.arange(rows) // 100,
    )


def log_for(effect: Effect) -> Log:
    """A log on which an effect acts."""
    return cell_log() if can_carry(CELLS, effect) and not only_on_hips(effect) else six_axis_log()


def only_on_hips(effect: Effect) -> bool:
    """Whether no log of cells knows what the effect needs."""
    return set(effect.experiments) <= {"hang", "pose"}


def typical(effect: Effect, units: int, seed: int = 0) -> Mapping[str, FloatArray]:
    """Sizes of the order of the prior sd, within the bounds, different for every owner."""
    rng = np.random.default_rng(seed)
    theta = {}
    for p in effect.parameters:
        if p.shape:
            theta[p.name] = np.full(units, SHAPES.get(p.name, p.neutral))
            continue
        drawn = p.neutral + p.prior_sd * rng.uniform(0.5, 1.5, units) * rng.choice([-1, 1], units)
        drawn = np.where(drawn < p.lower, 2.0 * p.neutral - drawn, drawn)
        theta[p.name] = np.clip(drawn, p.lower, p.upper)
    return theta


def difference(a: Log, b: Log) -> float:
    """Largest difference of two logs over the largest value, readings and known alike."""
    pairs = [(a.readings, b.readings), *((a.known[k], b.known[k]) for k in a.known)]
    return max(
        float(np.nanmax(np.abs(x - y), initial=0.0)) / max(float(np.nanmax(np.abs(x))), 1e-300)
        for x, y in pairs
    )
