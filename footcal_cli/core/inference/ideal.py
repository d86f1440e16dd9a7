"""Recordings as they would be without noise and without anything wrong, to take derivatives at."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from footcal_cli.core.chain import Chain, Seen
from footcal_cli.core.experiments.contract import Balance, Experiment
from footcal_cli.core.inference.case import Case
from footcal_cli.core.inference.exogenous import acting, shared_with_inputs, torques
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import BoolArray, FloatArray
from footcal_cli.core.signals import means_of, stretches

TORQUE_SHARE = 0.1  # noise of a torque axis in Nm, per newton of noise of a force axis
_BESIDE_S, _ALIKE_S = 0.2, 0.03
"""So long before and after a swing its cells are taken to read what they read in it on average, and
so long that smoothed noise hardly changes (5 Hz)."""


def balanced(
    case: Case,
    values: Mapping[str, float],
    chain: Chain | None = None,
    *,
    judged: bool = False,
    seen: Sequence[Seen] | None = None,
) -> Case:
    """The same recordings as they would be had nothing been wrong and no noise been there.

    ``F′ = F − Σ Aᵀ (A Σ Aᵀ)⁻¹ e``: the smallest change of the readings, in units of their noise,
    that makes the balance hold; A is the balance's derivative by the readings. Signatures and
    calibration columns are taken there. Taken at the noisy readings they would share their noise
    with the residual: a free scale and a known load then explain every error away, and clean data
    look like a gain error.

    Parameters
    ----------
    judged
        Whether the judged rows are enough; of a chain with a memory all are returned.
    seen
        From `Case.memory`, where the chain was removed at these values before.
    """
    used = chain or case.chain
    few = judged and case.stride > 1 and not used.remembers(values)
    logs = []
    for number, log in enumerate(case.logs):
        of_log = None if seen is None else seen[number]
        truth = used.truth(case.judged[number] if few else log, values, of_log)
        balance, derivative, spread = _linearised(case, truth)
        if not case.demand_noisy:
            error = np.where(balance.valid, np.nan_to_num(balance.error), 0.0)
            change = _least_change(derivative, error, balance.valid) * spread
            ideal = truth.with_readings(truth.readings - change)
        else:
            whole = used.truth(log, values, of_log) if few else truth
            rows = slice(None, None, case.stride if few else 1)
            of_whole = case.experiment.balance(whole) if few else balance
            parts = _noise_of_both_sides(case.experiment, whole, of_whole, derivative / spread)
            beside, settled, felt, turning = parts
            free = derivative * np.where(settled[rows], 0.0, 1.0)[:, None]
            change = beside[rows] + _least_change(free, felt[rows], balance.valid) * spread
            ideal = truth.with_readings(truth.readings - change)
            ideal = _demand_moved(case.experiment, ideal, balance.outputs, turning[rows])
        logs.append(used.apply(ideal, values)[0])
    return replace(case, logs=tuple(logs), stride=1 if few else case.stride)


def _linearised(case: Case, truth: Log) -> tuple[Balance, FloatArray, FloatArray]:
    """Balance of a log, its derivative by the readings in units of noise, (n, k, c), and these."""
    balance = case.experiment.balance(truth)
    spread = np.where(torques(truth.channels), TORQUE_SHARE, 1.0)
    derivative = np.empty((*balance.error.shape, spread.size))
    for c in range(spread.size):
        moved = truth.readings.copy()
        moved[:, c] += spread[c]
        change = case.experiment.balance(truth.with_readings(moved)).error - balance.error
        derivative[:, :, c] = np.where(balance.valid & np.isfinite(change), change, 0.0)
    return balance, derivative, spread


def _least_change(derivative: FloatArray, error: FloatArray, valid: BoolArray) -> FloatArray:
    """``Aᵀ (A Aᵀ)⁻¹ e`` of each row, (n, c); rows with the same valid outputs are solved at once.

    Parameters
    ----------
    derivative
        A in units of the channels' noise, zero where an output is not valid, (n, k, c).
    error, valid
        e and the outputs that count, (n, k).
    """
    change = np.zeros((len(derivative), derivative.shape[2]))
    pattern = np.packbits(valid, axis=1).astype(np.int64) @ 256 ** np.arange(
        -(-valid.shape[1] // 8)
    )
    kinds, first, kind = np.unique(pattern, return_index=True, return_inverse=True)
    for number in range(kinds.size):
        rows, outputs = np.flatnonzero(kind == number), np.flatnonzero(valid[first[number]])
        if not outputs.size:
            continue
        one = derivative[np.ix_(rows, outputs)]
        normal = one @ one.transpose(0, 2, 1)
        diagonal = np.einsum("nii->ni", normal)  # a view
        diagonal += (1e-10 * diagonal.sum(axis=1) + 1e-300)[:, None]
        pull = np.linalg.solve(normal, error[np.ix_(rows, outputs)][..., None])
        change[rows] = np.einsum("nkc,nk->nc", one, pull[..., 0])
    return change


def _noise_of_both_sides(
    experiment: Experiment, truth: Log, balance: Balance, derivative: FloatArray
) -> tuple[FloatArray, BoolArray, FloatArray, FloatArray]:
    """Noise of channels beside swings and where that is all of it, (n, c); and parts of the rest.

    Parameters
    ----------
    truth, balance
        All rows of a walk.
    derivative
        Of the balance by the channels, of some rows, (m, k, c).

    Returns
    -------
    beside, settled, and what readings and L̇ hold of the rest, (n, k).
    """
    beside, settled = _noise_beside(truth, balance, derivative)
    quiet = truth.with_readings(truth.readings - beside)
    balance = experiment.balance(quiet)
    felt, turning = shared_with_inputs(experiment, quiet, balance, derivative)
    felt = np.where((acting(derivative) == 1) & balance.valid, np.nan_to_num(balance.error), felt)
    return beside, settled, felt, turning


def _noise_beside(
    truth: Log, balance: Balance, derivative: FloatArray
) -> tuple[FloatArray, BoolArray]:
    """Noise of channels in rows that demand nothing of them, from rows beside that do, (n, c).

    A cell in the air reads its noise, and reads it just before and after too: so near that a low-
    pass makes both alike it shows what it shows there, farther off the noise of that swing on
    average. Left in there, all that remembers a load would remember what is the residual of the
    swing. Nor may such a row take part in what the totals are off by: a swing would begin with a
    step, which a lag remembers at its largest.

    Parameters
    ----------
    derivative
        Of the balance by the channels, zero where an output is not valid, of some rows, (m, k, c).

    Returns
    -------
    The noise, and where a channel reads what it reads in the swing beside, (n, c).
    """
    time_s, noise = truth.time_s, np.zeros_like(truth.readings)
    settled = np.zeros(noise.shape, dtype=bool)
    alone = (acting(derivative) == 1) & ~balance.valid.all(axis=0)
    for k in np.flatnonzero(alone):
        row, channel = divmod(int(np.argmax(derivative[:, k] != 0.0)), derivative.shape[2])
        shown = truth.readings[:, channel]
        error = np.nan_to_num(balance.error[:, k]) / derivative[row, k, channel]
        for start, stop in stretches(balance.valid[:, k]):
            far, near = (
                np.searchsorted(time_s, (time_s[start] - reach, time_s[stop - 1] + reach))
                for reach in (_BESIDE_S, _ALIKE_S)
            )
            noise[slice(*far), channel] = error[start:stop].mean()
            for part, edge in ((slice(near[0], start), start), (slice(stop, near[1]), stop - 1)):
                noise[part, channel] = shown[part] - (shown[edge] - error[edge])
                settled[part, channel] = True
        noise[balance.valid[:, k], channel] = 0.0
        settled[balance.valid[:, k], channel] = False
    return noise, settled


def _demand_moved(
    experiment: Experiment, log: Log, outputs: Sequence[str], turning: FloatArray
) -> Log:
    """A standing or walking log whose body moves as the readings demand, where both are noisy.

    L̇ takes its part of the moments. Acceleration takes the rest of the forces, and that of the
    moments where no horizontal force is measured, else the horizontal place of the CoM does ([NAO],
    eqs. (9)–(11)). An acceleration is differentiated twice: left noisy, its derivatives share their
    noise with the residual. What a gait cycle shows on average is no noise: with a CoM that is off,
    an acceleration of ``g Δ / c_z`` would stand in every column of the acceleration.

    Parameters
    ----------
    outputs
        Of the balance.
    turning
        What L̇ holds of the errors, (n, k).
    """
    at = {name: i for i, name in enumerate(outputs)}
    if not {"fz", "mx", "my"} <= set(at):
        return log
    rate = log.known["angmom_rate_nm"] + turning[:, [at["mx"], at["my"]]]
    log = log.with_known(angmom_rate_nm=rate)
    balance = experiment.balance(log)

    cycle = log.block - log.block.min(initial=0)  # rows of none are −1

    def rest(name: str) -> FloatArray:
        counted = balance.valid[:, at[name]]
        error = balance.error[:, at[name]]
        mean = means_of(error[counted], cycle[counted], int(cycle.max(initial=-1)) + 1)
        return np.where(counted, error - mean[cycle], 0.0)

    mass = log.known["mass_kg"]
    acc, com = log.known["com_acc_mps2"].copy(), log.known["com_m"].copy()
    for axis, name in enumerate(("fx", "fy", "fz")):
        if name in at:
            acc[:, axis] += rest(name) / mass
    if "fx" in at:
        total = np.maximum(mass * (acc[:, 2] + log.known["gravity_mps2"]), 1.0)
        com[:, 0] -= rest("my") / total
        com[:, 1] += rest("mx") / total
    else:
        lever = mass * com[:, 2]
        acc[:, 0] += rest("my") / lever
        acc[:, 1] -= rest("mx") / lever
    return log.with_known(com_acc_mps2=acc, com_m=com)
