"""The physics engine's walks under sensor errors drawn anew.

`physics_walk` takes true loads and the body's noisy, late stream from the committed samples and
draws gains, biases, their drift, rounding and noise of the cells. `motion_walk` takes a motion of
``sample_data/physics/biped.py`` and draws the noise and jitter of the body's stream too.
"""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from footcal_cli.core.chain import Chain, link
from footcal_cli.core.effects import find_effect
from footcal_cli.core.log import Log
from footcal_cli.core.simulation.biped_logs import Streams
from tests.conftest import REPOSITORY
from tests.core.walk_data import CHANNELS, Array, Errors, Recording, coloured

SPEEDS = ("002", "004", "010")
MASS_KG = 5.3
TELEMETRY_S = 0.02
CELL_HZ = 80.0
FOLDER: Path = REPOSITORY / "sample_data/biped"

DRIFTING = Errors(bias_walk=0.03, gain_walk=4e-4, quantum=0.25)
"""2 % and 0.3 N off at the start; in a minute biases wander by 0.23 N, gains by 0.3 %."""

_PACKET_S = 5e-4


def physics_walk(speed: str, errors: Errors, seed: int) -> Recording:
    """A walk of the samples, its cells read with errors of this seed."""
    rng = np.random.default_rng(seed + 77_000)
    loads = pd.read_parquet(FOLDER / f"walk_{speed}_true_loads.parquet")
    body = pd.read_parquet(FOLDER / f"walk_{speed}_body.parquet")
    time = loads["time_s"].to_numpy(dtype=float)
    force = loads[[f"{c}_n" for c in CHANNELS]].to_numpy(dtype=float)
    return _recording(time, force, body["time_s"].to_numpy(dtype=float), body, errors, rng)


def motions() -> tuple[Path, ...]:
    """Walks that the engine made and no one tuned on, from ``FOOTCAL_MOTIONS``."""
    folder = os.environ.get("FOOTCAL_MOTIONS")
    if not folder:
        pytest.skip(
            "FOOTCAL_MOTIONS is not set: make motions with `python sample_data/physics/biped.py "
            "--seed 21 --out DIR` (extra: physics)"
        )
    return tuple(sorted(Path(folder).glob("motion_walk_*.parquet")))


def motion_walk(path: Path, errors: Errors, seed: int) -> Recording:
    """A motion of the engine with cells, body stream, its noise and its jitter of this seed."""
    rng = np.random.default_rng(seed + 55_000)
    motion, streams = pd.read_parquet(path), Streams()
    clock = motion["time_s"].to_numpy(dtype=float)
    clock = clock - clock[0]
    duration = float(clock[-1])

    def at(stamps: Array, names: list[str]) -> Array:
        return np.stack([np.interp(stamps, clock, motion[n].to_numpy(float)) for n in names], 1)

    time: Array = np.arange(int(duration * CELL_HZ)) / CELL_HZ
    force = at(time, [f"{c}_n" for c in CHANNELS])
    rows = int(duration * streams.body_rate_hz)
    taken: Array = (np.arange(float(rows)) + 0.37) / streams.body_rate_hz
    late = np.maximum(streams.body_delay_s + streams.body_jitter_s * rng.normal(size=rows), 0.0)
    # packets arrive in order, one after the other
    queue = _PACKET_S * np.arange(rows)
    stamped = np.maximum.accumulate(taken + late - queue) + queue
    names = [n for n in motion.columns if n.startswith(("com_", "angmom_", "left_foot", "right_"))]
    names = [n for n in names if not n.endswith("_n")]
    body = pd.DataFrame(dict(zip(names, at(taken, names).T, strict=True)))
    for start, sd in (
        ("com_acc", streams.acc_noise_mps2),
        ("com_", streams.com_noise_m),
        ("angmom", streams.angmom_noise_nm),
    ):
        chosen = [n for n in names if n.startswith(start) and (start != "com_" or "acc" not in n)]
        body[chosen] += rng.normal(0.0, sd, (rows, len(chosen)))
    return _recording(time, force, stamped, body, errors, rng)


def _recording(
    time: Array, force: Array, stamped: Array, body: pd.DataFrame, errors: Errors,
    rng: np.random.Generator,
) -> Recording:  # fmt: skip
    def columns(*names: str) -> Array:
        return body[list(names)].to_numpy(dtype=float)

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
        time, (shown - bias0) / scale0, stamped + errors.delay, com,
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


def with_hysteresis(recording: Recording, cell: int, width_n: float) -> Recording:
    """The same walk with a cell that lags behind its load."""
    name = CHANNELS[cell]
    newtons = recording.counts * recording.scale0 + recording.bias0
    n = len(newtons)
    log = Log("walk", CHANNELS, recording.cell_time, newtons, {}, np.zeros(n, dtype=np.int64))
    chain = Chain((link(find_effect("hysteresis"), CHANNELS, only=[name]),))
    values = {f"{name}.hysteresis_width": width_n, f"{name}.hysteresis_reach": 4.0}
    shown, _ = chain.apply(log, values)
    return replace(recording, counts=(shown.readings - recording.bias0) / recording.scale0)
