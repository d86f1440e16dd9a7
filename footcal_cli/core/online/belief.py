"""What is believed of the cells before a walk: a data sheet, or an earlier calibration.

What may be wrong with a belief is a relative gain γ and a bias β of each cell, in the centred units
of `footcal_cli.core.online.rows`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from footcal_cli.core.parameters import Estimates, FloatArray, Status

GAIN_SD = 0.02
BIAS_SD_N = 0.3
"""A nameplate's promise where nothing was calibrated (METHODS: gain ± 2 %, bias ± 0.3 N)."""
_IN_THE_AIR, _FAR = 0.03, 3.0
"""Quantile of a walking cell's forces at which it is in the air; sd at which a zero is unknown."""


@dataclass(frozen=True)
class Belief:
    """What is believed of the cells before the walk.

    Parameters
    ----------
    channels
        Cells, in the log's order.
    scale_n_per_count, bias_n
        ``c⁰``, ``d⁰``, shape (c,).
    covariance
        Of (γ of every cell, β of every cell), shape (2c, 2c).
    """

    channels: tuple[str, ...]
    scale_n_per_count: FloatArray
    bias_n: FloatArray
    covariance: FloatArray

    @property
    def gain_sd(self) -> FloatArray:
        """Shape (c,)."""
        return np.sqrt(np.diag(self.covariance)[: len(self.channels)])

    @property
    def bias_sd_n(self) -> FloatArray:
        """Shape (c,)."""
        return np.sqrt(np.diag(self.covariance)[len(self.channels) :])

    def with_zeros_in_the_air(self, forces_n: FloatArray) -> Belief:
        """Zeros as unsure as cells in the air show them, where nobody tared them.

        A zero that is far from what a data sheet promises would else be a jump at the first step.

        Parameters
        ----------
        forces_n
            Of a walk, in which each cell hangs in the air now and then, shape (n, c).
        """
        zero = np.abs(np.nanquantile(forces_n, _IN_THE_AIR, axis=0))
        unknown = zero > _FAR * self.bias_sd_n
        return self.widened(np.zeros(len(self.channels)), np.where(unknown, zero, 0.0))

    def widened(self, gain_sd: FloatArray, bias_sd_n: FloatArray) -> Belief:
        """The same belief with independent doubt added to gains and biases, shape (c,) each."""
        more = np.diag(np.concatenate([gain_sd, bias_sd_n]) ** 2)
        return replace(self, covariance=self.covariance + more)

    def forces(self, counts: FloatArray) -> FloatArray:
        """``F⁰ = c⁰ S + d⁰``, shape (n, c)."""
        return counts * self.scale_n_per_count + self.bias_n

    def per_gain_and_bias(self) -> FloatArray:
        """``∂(scales, biases)/∂(γ, β)``, shape (2c, 2c)."""
        c = len(self.channels)
        turn = np.zeros((2 * c, 2 * c))
        turn[:c, :c] = np.diag(self.scale_n_per_count)
        turn[c:, :c] = np.diag(self.bias_n)
        turn[c:, c:] = np.eye(c)
        return turn

    def estimates(
        self,
        gain: FloatArray,
        bias_n: FloatArray,
        covariance: FloatArray,
        status: Sequence[Status],
    ) -> Estimates:
        """Gains and biases on top of the belief as ``<cell>.scale`` and ``<cell>.bias``.

        Parameters
        ----------
        gain, bias_n
            γ, β, shape (c,).
        covariance
            Of (γ, β), shape (2c, 2c).
        status
            Of the scales, then of the biases.
        """
        c, turn = len(self.channels), self.per_gain_and_bias()
        return Estimates(
            names=tuple(f"{name}.scale" for name in self.channels)
            + tuple(f"{name}.bias" for name in self.channels),
            units=("N/count",) * c + ("N",) * c,
            values=np.concatenate(
                [self.scale_n_per_count * (1 + gain), self.bias_n * (1 + gain) + bias_n]
            ),
            covariance=turn @ covariance @ turn.T,
            status=tuple(status),
        )


def nameplate(
    channels: Sequence[str],
    scale_n_per_count: FloatArray,
    bias_n: FloatArray,
    gain_sd: float = GAIN_SD,
    bias_sd_n: float = BIAS_SD_N,
) -> Belief:
    """A belief from a data sheet: gains and biases with the same independent sd for all cells."""
    c = len(channels)
    variance = np.concatenate([np.full(c, gain_sd**2), np.full(c, bias_sd_n**2)])
    return Belief(tuple(channels), scale_n_per_count, bias_n, np.diag(variance))


def belief_from(
    estimates: Estimates,
    channels: Sequence[str],
    *,
    least_gain_sd: float = 1e-4,
    least_bias_sd_n: float = 1e-3,
) -> Belief:
    """A belief from an earlier calibration (`offline-fit`, `static-init`).

    Parameters
    ----------
    estimates
        With ``<cell>.scale`` and ``<cell>.bias`` of every channel.
    least_gain_sd, least_bias_sd_n
        Added in quadrature: a calibration of yesterday is not exact today.
    """
    at = [estimates.names.index(f"{name}.scale") for name in channels]
    at += [estimates.names.index(f"{name}.bias") for name in channels]
    c = len(channels)
    scale, bias = estimates.values[at[:c]], estimates.values[at[c:]]
    turn = np.zeros((2 * c, 2 * c))
    turn[:c, :c] = np.diag(1.0 / scale)
    turn[c:, :c] = np.diag(-bias / scale)
    turn[c:, c:] = np.eye(c)
    covariance = turn @ estimates.covariance[np.ix_(at, at)] @ turn.T
    floor = np.concatenate([np.full(c, least_gain_sd**2), np.full(c, least_bias_sd_n**2)])
    return Belief(tuple(channels), scale, bias, covariance + np.diag(floor))
