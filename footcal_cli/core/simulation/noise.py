"""What no effect explains: white and autocorrelated noise, and what differs between sessions."""

from __future__ import annotations

from dataclasses import dataclass, replace
from zlib import crc32

import numpy as np

from footcal_cli.core.effects.memory import linear_recurrence, low_pass_decay, recording
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import FloatArray


def stream(seed: int, name: str) -> np.random.Generator:
    """The random numbers of one named stream: independent of every other stream's use."""
    return np.random.default_rng(np.random.SeedSequence([seed, crc32(name.encode())]))


@dataclass(frozen=True)
class SimulatedNoise:
    """Noise of one kind of channel, in its unit.

    Parameters
    ----------
    white
        Sd of independent samples.
    wandering, wandering_time_s
        Sd and correlation time of a first-order autoregressive process.
    repeat_gain, repeat_offset
        Sd of the relative gain and of the offset drawn once per block (re-seating, warm-up).
    """

    white: float = 0.0
    wandering: float = 0.0
    wandering_time_s: float = 0.5
    repeat_gain: float = 0.0
    repeat_offset: float = 0.0

    def scaled(self, factor: float) -> SimulatedNoise:
        """The same noise, larger or smaller."""
        return SimulatedNoise(
            self.white * factor,
            self.wandering * factor,
            self.wandering_time_s,
            self.repeat_gain * factor,
            self.repeat_offset * factor,
        )

    def of_range(self, factor: float) -> SimulatedNoise:
        """The same noise of a sensor of another range: its gain errs by the same share."""
        return replace(self.scaled(factor), repeat_gain=self.repeat_gain)

    def added(
        self, signal: FloatArray, time_s: FloatArray, block: np.ndarray, rng: np.random.Generator
    ) -> FloatArray:
        """A signal (n, c) with this noise.

        The wandering part is stationary: ``a_k = ρ a_{k−1} + σ √(1 − ρ²) w_k``, ρ = exp(−Δt/τ).
        """
        noisy = signal.copy()
        if self.repeat_gain or self.repeat_offset:
            sessions, number = np.unique(block, return_inverse=True)
            shape = (sessions.size, signal.shape[1])
            noisy *= 1.0 + self.repeat_gain * rng.standard_normal(shape)[number]
            noisy += self.repeat_offset * rng.standard_normal(shape)[number]
        if self.white:
            noisy += self.white * rng.standard_normal(signal.shape)
        if self.wandering and len(signal):
            passed = recording(time_s, None)
            decay = low_pass_decay(passed.interval_s, np.array([self.wandering_time_s]))
            decay[passed.fresh] = 0.0
            drive = np.sqrt(1.0 - decay**2) * rng.standard_normal(signal.shape)
            noisy += self.wandering * linear_recurrence(decay, drive, np.zeros(signal.shape[1]))
        return noisy


CELL_NOISE = SimulatedNoise(0.03, 0.02, 0.5, 0.002, 0.02)
"""A load cell of a NAO-like foot, N."""
FORCE_NOISE, TORQUE_NOISE = SimulatedNoise(0.05, 0.02, 2.0), SimulatedNoise(0.004, 0.002, 2.0)
"""A six-axis transducer (ATI Gamma size), N and Nm."""
QUIET = SimulatedNoise()


def added_to_readings(
    log: Log, force: SimulatedNoise, torque: SimulatedNoise, rng: np.random.Generator
) -> Log:
    """A log whose readings carry noise: `force` on cells and forces, `torque` on torques."""
    is_torque = np.array([".t" in channel for channel in log.channels])
    readings = log.readings.copy()
    for kind, noise in ((~is_torque, force), (is_torque, torque)):
        if kind.any():
            readings[:, kind] = noise.added(log.readings[:, kind], log.time_s, log.block, rng)
    return log.with_readings(readings)
