"""Recordings as they would be without noise and without anything wrong, to take derivatives at."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from footcal_cli.core.chain import Chain
from footcal_cli.core.experiments.contract import Balance
from footcal_cli.core.inference.case import Case
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import FloatArray

TORQUE_SHARE = 0.1  # noise of a torque axis in Nm, per newton of noise of a force axis


def balanced(case: Case, values: Mapping[str, float], chain: Chain | None = None) -> Case:
    """The same recordings as they would be had nothing been wrong and no noise been there.

    ``F′ = F − Σ Aᵀ (A Σ Aᵀ)⁻¹ e``: the smallest change of the readings, in units of their noise,
    that makes the balance hold; A is the balance's derivative by the readings. Signatures and
    calibration columns are taken there. Taken at the noisy readings they would share their noise
    with the residual: a free scale and a known load then explain every error away, and clean data
    look like a gain error.
    """
    used = chain or case.chain
    logs = []
    for log in case.logs:
        truth, _ = used.remove(log, values)
        balance = case.experiment.balance(truth)
        error = np.where(balance.valid, balance.error, 0.0)
        spread = np.where(np.char.find(np.array(log.channels), ".t") >= 0, TORQUE_SHARE, 1.0)
        derivative = np.empty((*error.shape, len(log.channels)))
        for c in range(len(log.channels)):
            moved = truth.readings.copy()
            moved[:, c] += spread[c]
            change = case.experiment.balance(truth.with_readings(moved)).error - balance.error
            derivative[:, :, c] = np.where(balance.valid & np.isfinite(change), change, 0.0)
        error = np.nan_to_num(error)
        share = np.ones(error.shape[1])
        if case.demand_noisy:
            share = _reading_share(balance, derivative, case.stride, case.reading_noise_n)
        normal = derivative @ derivative.transpose(0, 2, 1)
        trace = np.einsum("nii->n", normal)
        diagonal = np.einsum("nii->ni", normal)  # a view
        diagonal += (1e-10 * trace + 1e-300)[:, None]
        pull = np.linalg.solve(normal, (share * error)[..., None])
        change = np.einsum("nkc,nk->nc", derivative, pull[..., 0]) * spread
        ideal = truth.with_readings(truth.readings - change)
        if case.demand_noisy:
            ideal = _demand_moved(ideal, case.experiment.balance(ideal))
        logs.append(used.apply(ideal, values)[0])
    return replace(case, logs=tuple(logs))


def _reading_share(
    balance: Balance, derivative: FloatArray, stride: int, least_n: float
) -> FloatArray:
    """Share of each output's noise that comes from the readings, shape (k,).

    The noise of single channels is seen where they must read zero (swing); noise is what changes
    from one judged row to the next. It is at least `least_n`: under load it may be larger, and a
    coarse converter shows none at rest.
    """
    noise = np.zeros(len(balance.outputs))
    for k in range(noise.size):
        both = balance.valid[stride:, k] & balance.valid[:-stride, k]
        steps = (balance.error[stride:, k] - balance.error[:-stride, k])[both]
        noise[k] = np.median(np.abs(steps)) ** 2 * 1.4826**2 / 2.0 if steps.size > 10 else np.nan
    moved_by = np.zeros(derivative.shape[:2], dtype=np.int64)
    for c in range(derivative.shape[2]):
        moved_by += derivative[:, :, c] != 0.0
    single = moved_by.max(axis=0, initial=0) == 1
    share = np.ones(noise.size)
    if not np.isfinite(noise[single]).any():
        return share
    of_reading = max(float(np.nanmedian(noise[single])), least_n**2)
    for k in range(noise.size):
        if not single[k] and np.isfinite(noise[k]):
            lever = float(np.mean(np.sum(derivative[balance.valid[:, k], k] ** 2, axis=1)))
            share[k] = np.clip(of_reading * lever / max(noise[k], 1e-300), 0.0, 1.0)
    return share


def _demand_moved(log: Log, balance: Balance) -> Log:
    """A standing or walking log whose body moves as the readings demand, where both are noisy.

    Acceleration takes the rest of the forces, and that of the moments where no horizontal force is
    measured, else the horizontal place of the CoM does ([NAO], eqs. (9)–(11)). An acceleration is
    differentiated twice: left noisy, its derivatives share their noise with the residual.
    """
    at = {name: i for i, name in enumerate(balance.outputs)}
    if not {"fz", "mx", "my"} <= set(at):
        return log

    def rest(name: str) -> FloatArray:
        return np.where(balance.valid[:, at[name]], balance.error[:, at[name]], 0.0)

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
