"""Errors of a foreign world's benches and legs against the Cramér–Rao bounds of its noise."""

from __future__ import annotations

import sys

import numpy as np
import pytest
from scipy.signal import lfilter

from footcal_cli.core import calibrate
from tests.foreign import draw_biped, draw_hexapod, hang, weights
from tests.foreign.biped import GRAVITY_MPS2, Biped
from tests.foreign.least import bench_noise
from tests.foreign.legs import DOWN, LEGS, Hexapod, arm_at
from tests.foreign.noise import Array
from tests.foreign.test_hanging import fits_of


def bound(robot: Biped, time_s: Array, load_n: Array) -> Array:
    """``sqrt diag (Aᵀ Σ⁻¹ A)⁻¹`` of relative scale and zero (N), with Σ as the world draws it."""
    noise = bench_noise(robot, time_s, load_n)
    a = np.column_stack([load_n, np.ones(load_n.size)])
    return np.asarray(np.sqrt(np.diag(np.linalg.inv(a.T @ np.linalg.solve(noise, a)))))


def ratios(seeds: range) -> tuple[Array, Array]:
    """Errors of scale and zero over their bound and over their stated sd, (channels, 2)."""
    over_bound, over_sd = [], []
    for seed in seeds:
        robot, frame = draw_biped(seed), weights(seed).logs["weights"]
        for i, channel in enumerate(robot.channels):
            one = frame[frame["channel"] == channel]
            load, time_s = one["load_n"].to_numpy(), one["time_s"].to_numpy()
            found = calibrate.weights(
                channel, load, one["counts"].to_numpy(), time_s=time_s,
                session=one["repeat"].to_numpy(),
            ).estimates  # fmt: skip
            scale, zero = robot.scale[i], robot.zero[i]
            rows = np.array([[1.0 / scale, 0.0], [zero, 1.0]])
            error = rows @ (found.values[:2] - [scale, -scale * zero])
            sd = np.sqrt(np.diag(rows @ found.covariance[:2, :2] @ rows.T))
            over_bound.append(error / bound(robot, time_s, load))
            over_sd.append(error / sd)
    return np.array(over_bound), np.array(over_sd)


@pytest.mark.slow
def test_weights_come_near_the_bound() -> None:
    over_bound, over_sd = ratios(range(500, 520))
    for k, name in enumerate(("scale", "zero")):
        share = np.sqrt(np.mean(over_bound[:, k] ** 2))
        stated = np.sqrt(np.mean(over_sd[:, k] ** 2))
        sys.stdout.write(
            f"weights, {name}: {share:.2f} of the bound, {stated:.2f} of the stated sd, "
            f"n = {len(over_bound)}\n"
        )
        assert share < 1.25


TILT_SD = float(np.hypot(0.02, 0.012))
"""Of gravity in a transducer from log to log: how the body leans and how it is mounted."""


def whitened(columns: Array, sd: float, memory: float, slow_share: float) -> Array:
    """Columns (n, p) in units of innovations of white and slow noise, an ARMA(1, 1)."""
    decay = np.exp(-1.0 / memory)
    white, drive = 1.0 - slow_share, slow_share * (1.0 - decay**2)
    level, next_to = drive + white * (1.0 + decay**2), -decay * white
    half = level / (2.0 * next_to)
    moving = half + np.sqrt(half**2 - 1.0)  # its own root inside the unit circle
    innovation = np.sqrt(next_to / moving)
    return np.asarray(lfilter([1.0, -decay], [1.0, moving], columns, axis=0) / (sd * innovation))


def hanging_bound(robot: Hexapod, k: int, phase: dict[str, Array]) -> Array:
    """Least sd of weight, offsets (6) and CoM (12) of a leg whose hanging logs have these angles.

    Unknown beside them: three turns per log, each drawn with `TILT_SD`.
    """
    weight, logs = robot.leg_kg[k] * GRAVITY_MPS2, list(phase)
    information = np.zeros((19 + 3 * len(logs),) * 2)
    tilts = np.arange(19, len(information))
    information[tilts, tilts] = TILT_SD**-2
    for log, (name, angle) in enumerate(phase.items()):
        down = robot.nominal_rot_bt[k].T @ np.array(DOWN[name])
        arm, n = arm_at(robot.arm_m[k], angle), len(angle)
        h = np.zeros((n, 6, len(information)))
        h[:, :3, 0], h[:, 3:, 0] = down, np.cross(arm, down)
        h[:, np.arange(6), 1 + np.arange(6)] = 1.0
        basis = [np.ones(n), np.sin(angle), np.cos(angle), np.sin(2 * angle)]
        for i, axis in enumerate(np.eye(3)):
            lever = np.cross(axis, weight * down)
            for b, part in enumerate(basis):
                h[:, 3:, 7 + 4 * i + b] = part[:, None] * lever
            pull = weight * np.cross(axis, down)
            h[:, :3, 19 + 3 * log + i], h[:, 3:, 19 + 3 * log + i] = pull, np.cross(arm, pull)
        for c, sd in enumerate(robot.noise_sd):
            one = whitened(h[:, c], sd, robot.kind.rate_hz, 0.3)
            information += one.T @ one
    return np.asarray(np.sqrt(np.diag(np.linalg.inv(information)))[:19])


@pytest.mark.slow
@pytest.mark.parametrize("turn_s", [6.0, 20.0, 60.0])
def test_hanging_legs_come_near_the_bound(turn_s: float) -> None:
    over: list[Array] = []
    for seed in range(100, 104):
        robot, recorded = draw_hexapod(seed), hang(seed, turn_s=turn_s)
        frame, fits = recorded.logs["hang"], fits_of(seed, turn_s)
        for k, leg in enumerate(LEGS):
            one = frame[frame["leg"] == leg]
            phase = {
                str(name): part["phase_rad"].to_numpy()
                for name, part in one.groupby("orientation", sort=False)
            }
            found, true = fits[leg].estimates, recorded.truth["parameters"]
            names = ("weight", *(f"offset_{a}" for a in ("fx", "fy", "fz", "tx", "ty", "tz")))
            error = [found[f"{leg}.{n}"] - true[f"{leg}.{n}"] for n in names]
            error += [
                found[f"{leg}.com_{a}_{b}"] - robot.arm_m[k, i, j]
                for i, a in enumerate("xyz")
                for j, b in enumerate(("mean", "sin", "cos"))
            ]
            least = hanging_bound(robot, k, phase)
            over.append(np.array(error) / np.delete(least, [10, 14, 18]))
    parts = {"weight": (0, 1), "force offset": (1, 4), "torque offset": (4, 7), "leg CoM": (7, 16)}
    for name, (first, last) in parts.items():
        share = float(np.sqrt(np.mean(np.square(over)[:, first:last])))
        sys.stdout.write(
            f"hanging, {turn_s:g} s a turn, {name}: {share:.2f} of the bound, "
            f"n = {len(over) * (last - first)}\n"
        )
        assert share < 1.5
