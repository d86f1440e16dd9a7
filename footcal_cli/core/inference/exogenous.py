"""What an error shares with its own inputs, so that columns taken at them are free of its noise.

A sole lies a millimetre from where the joints have it: the cells feel that, the model does not know
it, and the moment's error moves with the readings. An acceleration differentiated twice is noise
that no cell feels. Each side has frequencies of its own, and cycles of a gait differ by both.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from footcal_cli.core.contact import cycle_phase
from footcal_cli.core.effects.contract import Scope, columns_of
from footcal_cli.core.experiments.contract import Balance, Experiment
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import BoolArray, FloatArray, IntArray

_POINTS = 64
"""Of a cycle: 20 Hz of a cycle of 1.5 s, of which a low-pass at 10 Hz leaves nothing."""
_BANDS = np.array([0, 1, 2, 4, 8, 16])
"""First harmonic of each."""
_LEAST_CYCLES = 5


def shared_with_inputs(
    experiment: Experiment, log: Log, balance: Balance, derivative: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """What of each error the readings hold, and what L̇ does, each (n, k); without a gait: all, 0.

    ``e_x(f) = b_x(f) e(f), b_x = S_x / S_e`` with ``S_x = Re Σ ΔX ΔE*`` of an input X and
    ``S_e = Σ |ΔE|²``, by differences between consecutive cycles: ``X − b_x E`` is free of what
    it shares with the error E. Of all inputs the b sum to one. What repeats with the gait is no
    noise. Loads of feet shift from cycle to cycle far more than they are noisy: what their noise
    adds to a moment follows from that of the total force, ``S = Σ_c (∂m/∂F_c)² S_F / channels``.

    Parameters
    ----------
    experiment, log, balance
        Of a walk, all its rows.
    derivative
        Of the balance by the channels, of some rows, (m, k, c).

    Source: Durbin, Rev. Int. Stat. Inst. 22, 23 (1954), regressors that share the error's noise.
    """
    phase = cycle_phase(log.known["contact"])
    starts = np.flatnonzero(phase == 0.0)
    error = np.where(balance.valid, balance.error, np.nan)
    shared = np.stack([np.nan_to_num(error), np.zeros_like(error)])
    still = log.with_known(angmom_rate_nm=np.zeros((len(log), 2)))
    turning = balance.error - experiment.balance(still).error
    inputs = np.stack([error, _of_readings(experiment, log, balance), turning])
    cycles = [_cycles(one.T, starts) for one in np.moveaxis(inputs, 2, 0)]
    known = [k for k, own in enumerate(cycles) if len(own) >= _LEAST_CYCLES]
    power = np.zeros((len(cycles), len(inputs), _BANDS.size))
    for k in known:
        power[k] = _powers(cycles[k])
    power[:, 1] += _of_loads(log, balance, derivative) @ np.maximum(power[:, 1], 0.0)
    middle = 0.5 * (_BANDS + np.append(_BANDS[1:], _POINTS // 2) - 1)
    harmonic = np.fft.rfftfreq(len(log)) * np.median(np.diff(starts)) if known else np.empty(0)
    for k in known:
        odd = np.nan_to_num(error[:, k] - _repeated(cycles[k][:, 0].mean(axis=0), phase))
        own, *parts = power[k]
        for out, part in zip(shared, parts, strict=True):
            gain = np.clip(part / np.maximum(own, 1e-300), 0.0, 1.0)
            kept = np.fft.rfft(odd) * np.interp(harmonic, middle, gain)
            out[:, k] = np.where(balance.valid[:, k], np.fft.irfft(kept, odd.size), 0.0)
    return shared[0], shared[1]


def _of_loads(log: Log, balance: Balance, derivative: FloatArray) -> FloatArray:
    """Power that loads of feet add to each moment per power of each total force, (k, k)."""
    force, moment = (np.array([u == unit for u in balance.units]) for unit in ("N", "Nm"))
    total = force & (acting(derivative) > 1)
    squared, of_force = np.zeros((2, *derivative.shape[1:]))
    squared[moment] = np.mean(_untwisted(log.channels, derivative[:, moment]) ** 2, axis=0)
    of_force[total] = np.mean(derivative[:, total] ** 2, axis=0)
    main = of_force == of_force.max(axis=0, initial=1e-300)
    each = np.where(main, 1.0, 0.0) / np.maximum(np.sum(of_force * main, axis=1), 1e-300)[:, None]
    return np.asarray(squared @ each.T)


def _of_readings(experiment: Experiment, log: Log, balance: Balance) -> FloatArray:
    """What the readings add to each output, to a moment by turning about their own feet, (n, k)."""
    moment = np.array([unit == "Nm" for unit in balance.units])
    of_none, of_forces = (
        experiment.balance(log.with_readings(readings)).error
        for readings in (np.zeros_like(log.readings), _untwisted(log.channels, log.readings))
    )
    return np.asarray(balance.error - np.where(moment, of_forces, of_none))


def _untwisted(channels: Sequence[str], values: FloatArray) -> FloatArray:
    """Values of channels (..., c) without what turns about their own feet: means, no torques."""
    torque, out = torques(channels), values.copy()
    out[..., torque] = 0.0
    if not torque.any():
        for cells in columns_of(Scope.FOOT, channels):
            out[..., cells] = out[..., cells].mean(axis=-1, keepdims=True)
    return out


def torques(channels: Sequence[str]) -> BoolArray:
    """Which channels are torque axes, shape (c,)."""
    return np.asarray(np.char.find(np.array(channels), ".t") >= 0)


def acting(derivative: FloatArray) -> IntArray:
    """How many channels act on each output, of a balance's derivative (n, k, c); shape (k,)."""
    return np.asarray((derivative != 0.0).sum(axis=2).max(axis=0, initial=0))


def _cycles(series: FloatArray, starts: IntArray) -> FloatArray:
    """Series (n, s) on points of each cycle in which all are known, shape (cycles, s, points)."""
    found = []
    for start, stop in pairwise(starts):
        one = series[start:stop]
        if np.isfinite(one).all():
            at = np.arange(_POINTS) / _POINTS * (stop - start)
            found.append([np.interp(at, np.arange(stop - start), x) for x in one.T])
    return np.array(found).reshape(-1, series.shape[1], _POINTS)


def _repeated(cycle: FloatArray, phase: FloatArray) -> FloatArray:
    """A cycle's course (points,) at each phase, its mean where there is none, shape (n,)."""
    course = np.interp(phase, np.arange(_POINTS + 1) / _POINTS, np.append(cycle, cycle[0]))
    return np.asarray(np.where(np.isfinite(phase), course, cycle.mean()))


def _powers(cycles: FloatArray) -> FloatArray:
    """``Re Σ ΔX ΔE*`` per cycle and band of the error and its inputs, (s, points) of each cycle."""
    spectra = np.moveaxis(np.fft.rfft(np.diff(cycles, axis=0), axis=2), 1, 0)
    with_error = (spectra * spectra[0].conj()).real.mean(axis=1)
    return np.asarray(np.add.reduceat(with_error, _BANDS, axis=1))
