"""`hang-calib` on legs that turn quickly, in a world that it does not know."""

from __future__ import annotations

import sys

import numpy as np
import pytest

from footcal_cli.core.hang.intake import gravity_of_orientation, hang_log, shaft_motion
from footcal_cli.core.hang.joint import HangFit, fit_hang
from tests.foreign import draw_hexapod, hang
from tests.foreign.legs import AXES, LEGS
from tests.foreign.noise import Array

_NAMES = ("weight", *(f"offset_{a}" for a in ("fx", "fy", "fz", "tx", "ty", "tz")))


def fits_of(seed: int, turn_s: float, legs: tuple[str, ...] = LEGS) -> dict[str, HangFit]:
    frame, robot = hang(seed, turn_s=turn_s).logs["hang"], draw_hexapod(seed)
    fits = {}
    for leg in legs:
        one = frame[frame["leg"] == leg]
        gravity, _ = gravity_of_orientation(
            one["orientation"].to_numpy(), robot.nominal_rot_bt[LEGS.index(leg)]
        )
        time_s, phase = one["time_s"].to_numpy(), one["phase_rad"].to_numpy()
        wrench = one[list(AXES)].to_numpy()
        fits[leg] = fit_hang([hang_log(leg, time_s, phase, wrench, gravity, leg_weight_n=6.0)])
    return fits


def errors(seed: int, turn_s: float, legs: tuple[str, ...] = LEGS) -> tuple[Array, Array]:
    """Estimate − truth and its stated sd, (legs, 7)."""
    truth = hang(seed, turn_s=turn_s, turns=1.0).truth["parameters"]
    fits = fits_of(seed, turn_s, legs)
    error = [
        [fit.estimates[f"{leg}.{n}"] - truth[f"{leg}.{n}"] for n in _NAMES]
        for leg, fit in fits.items()
    ]
    return np.array(error), np.array([fit.estimates.sd[:7] for fit in fits.values()])


def test_a_leg_of_six_seconds_a_turn_leaves_no_acceleration_in_the_offsets() -> None:
    error, sd = errors(21, 6.0, ("fl", "mr"))
    # without the acceleration the offset along the shaft errs by 15 of its sd
    assert np.abs(error / sd).max() < 4.0
    assert np.abs(error[:, 1:4]).max() < 0.008


def test_drift_from_hold_to_hold_is_in_the_intervals_of_four_holds() -> None:
    error, sd = errors(7023, 20.0, ("fl", "mr"))  # offsets jump by 0.19 N, 10 mNm
    assert np.abs(error / sd).max() < 4.0
    # a sample's noise alone would have the weight known to 0.8 mN
    assert np.abs(error[:, 0]).max() > 0.01


def test_shaft_motion_is_that_of_the_angle_through_encoder_steps_and_wraps() -> None:
    time_s = np.arange(0.0, 30.0, 0.04)
    even = 2.0 * np.pi * time_s / 6.0
    phase = even + 0.15 * np.sin(even)
    rate = 2.0 * np.pi / 6.0
    step = 2.0 * np.pi / 4096
    seen = np.mod(np.round(phase / step) * step, 2.0 * np.pi)
    speed, acceleration = shaft_motion(time_s, seen)
    inner = slice(20, -20)
    true_speed = rate * (1.0 + 0.15 * np.cos(even))
    true_acceleration = -0.15 * rate**2 * np.sin(even)
    assert np.sqrt(np.mean((speed - true_speed)[inner] ** 2)) < 0.005 * rate
    assert np.sqrt(np.mean((acceleration - true_acceleration)[inner] ** 2)) < 0.02 * rate**2
    still, none = shaft_motion(time_s, np.full(time_s.size, 1.0))
    assert not still.any()
    assert not none.any()


@pytest.mark.slow
@pytest.mark.parametrize("turn_s", [6.0, 20.0, 60.0])
def test_intervals_hold_at_every_speed(turn_s: float) -> None:
    each = [errors(seed, turn_s) for seed in range(100, 110)]
    error, sd = (np.concatenate([e[i] for e in each]) for i in (0, 1))
    held = np.abs(error / sd) < 1.96
    parts = {"weight": slice(0, 1), "force offsets": slice(1, 4), "torque offsets": slice(4, 7)}
    for name, part in parts.items():
        share = held[:, part].mean()
        rms = np.sqrt(np.mean(error[:, part] ** 2))
        stated = np.sqrt(np.mean(sd[:, part] ** 2))
        said = f"{share:.3f} held, rms {rms:.3g}, stated {stated:.3g}"
        sys.stdout.write(f"hang {turn_s:g} s/turn, {name}: {said}\n")
        assert share > 0.85
