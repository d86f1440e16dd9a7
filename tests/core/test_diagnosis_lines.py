"""A hum is seen whatever rows are missing; noise of any colour, quantised or not, is none."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import lfilter

from footcal_cli.core.inference.lines import (
    Series,
    Traces,
    pieces_of,
    swing_series,
)
from footcal_cli.core.parameters import FloatArray

RATE_HZ, SECONDS, CHANNELS = 80.0, 40.0, 4
HUM_HZ = 17.3


def noise(rng: np.random.Generator, family: str) -> FloatArray:
    """Of every channel, unit RMS, shape (n, channels)."""
    white = rng.standard_normal((int(RATE_HZ * SECONDS), CHANNELS))
    if family == "ar98":
        return np.asarray(lfilter([np.sqrt(1 - 0.98**2)], [1.0, -0.98], white, axis=0))
    return np.round(white / 2.0) * 2.0 if family == "quantised" else white


def swings(forces: FloatArray) -> Series:
    """Feet that are lifted for 0.4 s of every second, the channels of two feet in turn."""
    time_s = np.arange(len(forces)) / RATE_HZ
    phase = (time_s[:, None] + 0.5 * (np.arange(CHANNELS) % 2)) % 1.0
    names = tuple(f"cell {i}" for i in range(CHANNELS))
    return swing_series(time_s, forces, phase < 0.4, names, RATE_HZ)


@pytest.mark.parametrize("draws", [25, pytest.param(60, marks=pytest.mark.slow)])
@pytest.mark.parametrize("family", ["white", "ar98", "quantised"])
def test_noise_has_no_line(family: str, draws: int) -> None:
    rng = np.random.default_rng(3)
    p = np.array([swings(noise(rng, family)).strongest.p for _ in range(draws)])
    assert p.min() > 2e-3  # one in 500 is what the test is used at


@pytest.mark.parametrize("family", ["white", "ar98", "quantised"])
def test_a_hum_of_half_the_noise_is_a_line_at_its_frequency(family: str) -> None:
    rng = np.random.default_rng(4)
    time_s = np.arange(int(RATE_HZ * SECONDS)) / RATE_HZ
    hum = 0.5 * np.sqrt(2.0) * np.sin(2 * np.pi * HUM_HZ * time_s)
    line = swings(noise(rng, family) + hum[:, None]).strongest
    assert line.p < 1e-6
    # lifted once a second, a foot samples the hum with side lines a hertz apart
    assert abs((line.frequency_hz - HUM_HZ + 0.5) % 1.0 - 0.5) < 0.1
    assert abs(line.frequency_hz - HUM_HZ) < 2.2


def test_what_repeats_with_every_swing_is_no_line() -> None:
    rng = np.random.default_rng(5)
    time_s = np.arange(int(RATE_HZ * SECONDS)) / RATE_HZ
    shaken = np.sin(2 * np.pi * 5.0 * time_s) * np.exp(-8.0 * (time_s % 0.5))
    assert swings(noise(rng, "white") + 0.5 * shaken[:, None]).strongest.p > 2e-3


def test_a_channel_that_shows_one_code_has_no_line() -> None:
    forces = np.zeros((int(RATE_HZ * SECONDS), CHANNELS))
    forces[1500:, :] = 0.5
    assert swings(forces).strongest.p == 1.0


def test_no_piece_goes_on_across_a_pause() -> None:
    """Forty seconds of hanging, a minute in which the robot is hung anew, forty seconds."""
    spell = np.arange(0.0, 40.0, 0.4)
    time_s = np.concatenate([spell, spell + 100.0])
    traces = Traces(time_s, np.zeros(time_s.size, dtype=np.int64), ("fx",))
    pieces = pieces_of(traces, 2.5)
    assert [rows.size for rows in pieces] == [spell.size, spell.size]


@pytest.mark.parametrize("height", [0.4, 2.0])
def test_a_line_has_the_rms_of_its_wave(height: float) -> None:
    rng = np.random.default_rng(6)
    time_s = np.arange(4000) / RATE_HZ
    hum = height * np.sqrt(2.0) * np.sin(2 * np.pi * HUM_HZ * time_s)
    traces = Traces(time_s, np.zeros(4000, dtype=int), ("fz",))
    line = traces.series(hum + 0.5 * rng.standard_normal(4000), RATE_HZ).strongest
    assert line.p < 1e-6
    assert line.rms == pytest.approx(height, rel=0.15)


def test_what_repeats_with_every_swing_is_no_line_at_two_kilohertz_either() -> None:
    """A plate that swings leaves a shape far larger than the noise, and a part is many samples."""
    rng, rate_hz = np.random.default_rng(6), 2000.0
    time_s = np.arange(int(rate_hz * 20.0)) / rate_hz
    phase = (time_s[:, None] + 0.5 * (np.arange(2) % 2)) % 1.0
    shaken = 5.0 * np.sin(2 * np.pi * 2.5 * phase)
    forces = shaken + rng.standard_normal((time_s.size, 2))
    found = swing_series(time_s, forces, phase < 0.4, ("left", "right"), rate_hz)
    assert found.strongest.p > 2e-3
