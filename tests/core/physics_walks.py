"""The physics-engine walks of `sample_data` under sensor errors drawn anew.

True loads and the body's noisy, late stream are those of the samples; gains, biases, their drift,
rounding and noise of the cells come from here.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd

from tests.conftest import REPOSITORY
from tests.core.walk_data import CHANNELS, Array, Errors, Recording, coloured

SPEEDS = ("002", "004", "010")
MASS_KG = 5.3
TELEMETRY_S = 0.02
FOLDER: Path = REPOSITORY / "sample_data/biped"

DRIFTING = Errors(bias_walk=0.03, gain_walk=4e-4, quantum=0.25)
"""2 % and 0.3 N off at the start; in a minute biases wander by 0.23 N, gains by 0.3 %."""


def physics_walk(speed: str, errors: Errors, seed: int) -> Recording:
    """A walk of the samples, its cells read with errors of this seed."""
    rng = np.random.default_rng(seed + 77_000)
    loads = pd.read_parquet(FOLDER / f"walk_{speed}_true_loads.parquet")
    body = pd.read_parquet(FOLDER / f"walk_{speed}_body.parquet")

    def columns(*names: str) -> Array:
        return body[list(names)].to_numpy(dtype=float)

    time = loads["time_s"].to_numpy(dtype=float)
    force = loads[[f"{c}_n" for c in CHANNELS]].to_numpy(dtype=float)
    n, step = len(time), float(np.median(np.diff(time)))
    scale0 = -rng.uniform(2.2e-6, 3.6e-6, 8)
    bias0 = -scale0 * rng.uniform(8.31e6, 8.35e6, 8)

    def wander(sd: float, start_sd: float) -> Array:
        steps = rng.normal(0.0, sd * np.sqrt(step), (n, 8))
        return rng.normal(0.0, start_sd, 8) + np.cumsum(steps, axis=0)

    gain, bias = wander(errors.gain_walk, errors.gain_sd), wander(errors.bias_walk, errors.bias_sd)
    for cell, when, size in errors.jumps:
        bias[time >= when, cell] += size
    contact = np.stack([force[:, :4].sum(axis=1) > 0.5, force[:, 4:].sum(axis=1) > 0.5], axis=1)
    seen = force + rng.normal(0.0, errors.white, force.shape)
    seen += coloured(rng, n, errors.slow, 40, 8)
    seen -= np.repeat(~contact, 4, axis=1) * errors.plate / 4
    shown = (seen - bias) / (1 + gain)
    shown = np.round(shown / errors.quantum) * errors.quantum
    feet = np.stack(
        [columns(f"{foot}_foot_x_m", f"{foot}_foot_y_m") for foot in ("left", "right")], axis=1
    )
    com = columns("com_x_m", "com_y_m", "com_z_m").copy()
    com[:, :2] -= np.array(errors.com_offset)
    return Recording(
        time, (shown - bias0) / scale0, body["time_s"].to_numpy(dtype=float) + errors.delay, com,
        columns("com_acc_x_mps2", "com_acc_y_mps2", "com_acc_z_mps2"),
        columns("angmom_rate_x_nm", "angmom_rate_y_nm"), feet,
        columns("left_foot_yaw_rad", "right_foot_yaw_rad"), scale0, bias0, gain, bias, force,
        np.zeros((n, 8, 2)), contact.astype(float), MASS_KG,
    )  # fmt: skip


def with_body_errors(errors: Errors, seed: int) -> Errors:
    """The same, and a body model 1.5 mm off and a clock 3 ms off (1 sd), drawn by the seed."""
    rng = np.random.default_rng(seed + 99_000)
    offset = rng.normal(0.0, 0.0015, 2)
    return replace(
        errors, delay=float(rng.normal(0.0, 0.003)), com_offset=(float(offset[0]), float(offset[1]))
    )
