"""Recordings as they would be without noise and without anything wrong, to take derivatives at."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from footcal_cli.core.chain import Chain, Seen
from footcal_cli.core.experiments.contract import Balance
from footcal_cli.core.inference.case import Case
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import BoolArray, FloatArray
from footcal_cli.core.signals import means_of

TORQUE_SHARE = 0.1  # noise of a torque axis in Nm, per newton of noise of a force axis
_FEW_STEPS = 10


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
        share = np.ones(len(balance.outputs))
        if case.demand_noisy:
            whole = case.experiment.balance(used.truth(log, values, of_log)) if few else balance
            at = slice(None, None, 1 if few else case.stride)
            noise = _noise(whole, case.stride)
            share = _reading_share(noise, derivative[at], balance.valid[at], case.reading_noise_n)
        error = np.where(balance.valid, np.nan_to_num(balance.error), 0.0)
        change = _least_change(derivative, share * error, balance.valid) * spread
        ideal = truth.with_readings(truth.readings - change)
        if case.demand_noisy:
            ideal = _demand_moved(ideal, case.experiment.balance(ideal))
        logs.append(used.apply(ideal, values)[0])
    return replace(case, logs=tuple(logs), stride=1 if few else case.stride)


def _linearised(case: Case, truth: Log) -> tuple[Balance, FloatArray, FloatArray]:
    """Balance of a log, its derivative by the readings in units of noise, (n, k, c), and these."""
    balance = case.experiment.balance(truth)
    spread = np.where(np.char.find(np.array(truth.channels), ".t") >= 0, TORQUE_SHARE, 1.0)
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


def _noise(balance: Balance, stride: int) -> FloatArray:
    """Squared noise of each output, NaN where few rows count, (k,): steps between judged rows."""
    noise = np.full(len(balance.outputs), np.nan)
    for k in range(noise.size):
        both = balance.valid[stride:, k] & balance.valid[:-stride, k]
        steps = (balance.error[stride:, k] - balance.error[:-stride, k])[both]
        if steps.size > _FEW_STEPS:
            noise[k] = np.median(np.abs(steps)) ** 2 * 1.4826**2 / 2.0
    return noise


def _reading_share(
    noise: FloatArray, derivative: FloatArray, valid: BoolArray, least_n: float
) -> FloatArray:
    """Share of each output's noise that comes from the readings, shape (k,).

    The noise of single channels is seen where they must read zero (swing). It is at least
    `least_n`: under load it may be larger, and a coarse converter shows none at rest.

    Parameters
    ----------
    noise
        Squared, of each output, (k,).
    derivative, valid
        Of the judged rows, (n, k, c) and (n, k).
    """
    acting = (derivative != 0.0) @ np.ones(derivative.shape[2])
    single = acting.max(axis=0, initial=0) == 1
    share = np.ones(noise.size)
    if not np.isfinite(noise[single]).any():
        return share
    of_reading = max(float(np.nanmedian(noise[single])), least_n**2)
    for k in np.flatnonzero(~single & np.isfinite(noise)):
        mine = derivative[valid[:, k], k]
        lever = float(np.mean(np.einsum("nc,nc->n", mine, mine)))
        share[k] = np.clip(of_reading * lever / max(noise[k], 1e-300), 0.0, 1.0)
    return share


def _demand_moved(log: Log, balance: Balance) -> Log:
    """A standing or walking log whose body moves as the readings demand, where both are noisy.

    Acceleration takes the rest of the forces, and that of the moments where no horizontal force is
    measured, else the horizontal place of the CoM does ([NAO], eqs. (9)–(11)). An acceleration is
    differentiated twice: left noisy, its derivatives share their noise with the residual. What a
    gait cycle shows on average is no noise: with a CoM that is off, an acceleration of
    ``g Δ / c_z`` would stand in every column of the acceleration.
    """
    at = {name: i for i, name in enumerate(balance.outputs)}
    if not {"fz", "mx", "my"} <= set(at):
        return log

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
