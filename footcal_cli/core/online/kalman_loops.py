"""The Kalman step of `footcal_cli.core.inference.kalman` in loops over a walk.

Written for a compiler (numba).

`footcal_cli.core.online.filter` and its array code give the same answers, slower, where there is
no compiler (`footcal_cli.core.online.loops`).
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from footcal_cli.core.online.loops import compiled

_LOG_2PI = 1.8378770664093453


class Room(NamedTuple):
    """What one update works with, for at most k rows and s states.

    `at` numbers its valid rows, `design` is their H (k, s); `nu`, `standard` and `variance` are ν,
    z and the diagonal of S (k,); `total` becomes L (k, k), `weight` W (k, s).
    """

    at: Any
    design: Any
    nu: Any
    standard: Any
    variance: Any
    total: Any
    weight: Any


@compiled
def _room(k: int, s: int) -> Any:
    """Room for updates of k rows and s states."""
    return Room(
        np.empty(k, np.int64), np.zeros((k, s)), np.empty(k), np.empty(k), np.empty(k),
        np.empty((k, k)), np.empty((k, s)),
    )  # fmt: skip


@compiled
def _cholesky(a: Any, n: int) -> float:
    """Factor the lower triangle of the leading n × n block in place; ln det."""
    log_det = 0.0
    for i in range(n):
        for j in range(i + 1):
            total = a[i, j]
            for m in range(j):
                total -= a[i, m] * a[j, m]
            if i == j:
                if not total > 0.0:
                    return np.nan
                a[i, i] = np.sqrt(total)
                log_det += 2.0 * np.log(a[i, i])
            else:
                a[i, j] = total / a[j, j]
    return log_det


@compiled
def _rows_at(j: int, rows: int, given: Any, room: Any) -> None:
    """H of the valid rows of update j, states of the correlated errors included."""
    h, own_start, out = given.h, given.own_start, room.design
    p = h.shape[2]
    for i in range(rows):
        r = room.at[i]
        for m in range(p):
            out[i, m] = h[j, r, m]
        for m in range(given.fixed.shape[1]):
            out[i, p + m] = given.fixed[r, m]
        for m in range(given.soles.shape[2]):
            change = given.soles[j, r, m] if r < given.totals else 0.0
            out[i, p + given.fixed.shape[1] + m] = change
        if own_start >= 0:
            for m in range(given.own.size):
                out[i, own_start + m] = h[j, r, given.own[m]] * given.own_scale[m]


@compiled
def _innovate(
    j: int, rows: int, setting: int, given: Any, huber: float, mean: Any, cov: Any, room: Any
) -> float:
    """Fill ν, L, W, z and the variances of update j; ln det S."""
    s, at, hh, total, weight = mean.size, room.at, room.design, room.total, room.weight
    white, shared = given.white[setting], given.shared[setting]
    h, own, own_scale, stamps = given.h, given.own, given.own_scale, given.stamps
    for i in range(rows):
        value = given.error[j, at[i]]
        for m in range(s):
            value += hh[i, m] * mean[m]
        room.nu[i] = -value
        for n in range(s):
            weight[i, n] = 0.0
        for m in range(s):
            factor = hh[i, m]
            if factor != 0.0:
                for n in range(s):
                    weight[i, n] += factor * cov[m, n]
    for i in range(rows):
        r = at[i]
        for k in range(i + 1):
            q = at[k]
            value = 0.0
            for m in range(s):
                value += weight[i, m] * hh[k, m]
            if shared[0] > 0.0 and own.size > 0:
                both = 0.0
                for m in range(own.size):
                    both += h[j, r, own[m]] * h[j, q, own[m]] * own_scale[m] * own_scale[m]
                value += shared[0] * both
            if stamps.shape[0] > 0 and r < given.totals and q < given.totals:
                value += shared[1] * stamps[j, r] * stamps[j, q]
            if i == k:
                value += white[r]
                room.variance[i] = value
                value = max(value, room.nu[i] * room.nu[i] / (huber * huber))
            total[i, k] = value
    log_det = _cholesky(total, rows)
    for i in range(rows):
        value = room.nu[i]
        for m in range(i):
            factor = total[i, m]
            value -= factor * room.standard[m]
            for n in range(s):
                weight[i, n] -= factor * weight[m, n]
        scale = 1.0 / total[i, i]
        room.standard[i] = value * scale
        for n in range(s):
            weight[i, n] *= scale
    return log_det


@compiled
def _correct(mean: Any, cov: Any, rows: int, room: Any) -> None:
    """``x̂ + Wᵀ z`` and ``P − Wᵀ W`` in place."""
    s, weight = mean.size, room.weight
    for i in range(rows):
        z = room.standard[i]
        for m in range(s):
            w = weight[i, m]
            mean[m] += w * z
            for n in range(s):
                cov[m, n] -= w * weight[i, n]


@compiled
def _predict(mean: Any, cov: Any, decay: Any, drive: Any) -> None:
    """``Φ x̂`` and ``Φ P Φ + Q`` in place."""
    s = mean.size
    for m in range(s):
        mean[m] *= decay[m]
        for n in range(s):
            cov[m, n] *= decay[m] * decay[n]
        cov[m, m] += drive[m]


@compiled
def _valid_at(valid: Any, j: int, at: Any) -> int:
    """Numbers of the valid rows of update j, and how many there are."""
    count = 0
    for r in range(valid.shape[1]):
        if valid[j, r]:
            at[count] = r
            count += 1
    return count


@compiled
def _taught(cov: Any, weight: Any, rows: int, p: int, before: Any, after: Any) -> float:
    """``½ ln (det P / det (P − Wᵀ W))`` of the first p states."""
    for m in range(p):
        for n in range(m + 1):
            value = cov[m, n]
            before[m, n] = value
            for i in range(rows):
                value -= weight[i, m] * weight[i, n]
            after[m, n] = value
    return 0.5 * (_cholesky(before, p) - _cholesky(after, p))


@compiled
def filter_settings(
    mean: Any, cov: Any, given: Any, interval: Any, opened: Any, huber: float, keep: bool,
    values: Any, momentary: Any,
) -> Any:  # fmt: skip
    """Filter a walk with B settings of the noise, one after another; ln likelihood of each.

    `given` is a `footcal_cli.core.online.passes.PassInput`; `values` and `momentary` are filled
    where they are to be kept.
    """
    walk, slow = given.walk, given.slow
    b, p = walk.shape
    u, k = given.error.shape
    s = mean.size
    result = np.zeros(b)
    x, cx = np.empty(s), np.empty((s, s))
    room = _room(k, s)
    decay, drive = np.ones(s), np.empty(s)
    shifts = s - p - given.renewed.shape[1]
    for setting in range(b):
        x[:] = mean
        cx[:, :] = cov
        for e in range(s - p):
            cx[p + e, p + e] = slow[setting, e]
        likelihood = 0.0
        for j in range(u):
            for m in range(p):
                drive[m] = walk[setting, m] * interval[j] + opened[j, m]
            for e in range(s - p):
                d = np.exp(-interval[j] / given.slow_s[setting, e])
                if e >= shifts and given.renewed[j, e - shifts]:
                    d = 0.0
                decay[p + e] = d
                drive[p + e] = slow[setting, e] * (1.0 - d * d)
            _predict(x, cx, decay, drive)
            rows = _valid_at(given.valid, j, room.at)
            if rows > 0:
                _rows_at(j, rows, given, room)
                log_det = _innovate(j, rows, setting, given, huber, x, cx, room)
                nis = 0.0
                for i in range(rows):
                    nis += room.standard[i] * room.standard[i]
                likelihood -= 0.5 * (nis + log_det + rows * _LOG_2PI)
                _correct(x, cx, rows, room)
            if keep:
                for m in range(p):
                    values[j, setting, m] = x[m]
                for m in range(given.seen.size):
                    momentary[j, setting, m] = x[given.seen[m]]
        result[setting] = likelihood
    return result


@compiled
def filter_walk(
    mean: Any, cov: Any, given: Any, decays: Any, drives: Any, huber: float, least_gain: float,
    found: Any, bank: Any,
) -> Any:  # fmt: skip
    """Filter a walk with one setting; the bank of jumps along, where it has any biases.

    `given`, `found` and `bank` are a `PassInput`, `FilterOutput` and `PlainBank` of
    `footcal_cli.core.online.passes`; `mean` and `cov` are left as after the last update. Returns
    ln likelihood and number of jumps.
    """
    u, k = given.error.shape
    s, p = mean.size, given.h.shape[2]
    room = _room(k, s)
    before, after = np.empty((p, p)), np.empty((p, p))
    likelihood = 0.0
    jumps: Any = np.int64(0)  # a literal would compile `_jump` for itself
    history = found.past_mean.shape[0] > 0
    for j in range(u):
        _predict(mean, cov, decays[j], drives[j])
        if history:
            found.ahead_mean[j] = mean
            found.ahead_cov[j] = cov
        rows = _valid_at(given.valid, j, room.at)
        if rows > 0:
            _rows_at(j, rows, given, room)
            log_det = _innovate(j, rows, 0, given, huber, mean, cov, room)
            for i in range(rows):
                found.innovation[j, room.at[i]] = room.nu[i]
                found.innovation_var[j, room.at[i]] = room.variance[i]
                found.nis[j] += room.standard[i] * room.standard[i]
            likelihood -= 0.5 * (found.nis[j] + log_det + rows * _LOG_2PI)
            found.gain_nats[j] = _taught(cov, room.weight, rows, p, before, after)
            if found.gain_nats[j] > least_gain:
                found.used[j] = True
                _correct(mean, cov, rows, room)
                if bank.biases.size > 0:
                    jumps = _jump(j, rows, decays[j], mean, cov, room, bank, jumps)
        for m in range(p):
            found.values[j, m] = mean[m]
            found.variances[j, m] = cov[m, m]
        for m in range(given.seen.size):
            found.momentary[j, m] = mean[given.seen[m]]
        if history:
            found.past_mean[j] = mean
            found.past_cov[j] = cov
    return likelihood, jumps


@compiled
def _jump(
    j: int, rows: int, decay: Any, mean: Any, cov: Any, room: Any, bank: Any, jumps: int
) -> int:
    """`footcal_cli.core.online.jumps.BiasJumpBank.update`; how many jumps have been found."""
    biases, response, score, weighed = bank.biases, bank.response, bank.score, bank.information
    weight, chol, standard = room.weight, room.total, room.standard
    s, size, count = response.shape
    slot = j % size
    for m in range(s):
        for o in range(size):
            for c in range(count):
                response[m, o, c] *= decay[m]
    for c in range(count):
        for m in range(s):
            response[m, slot, c] = 0.0
        response[biases[c], slot, c] = 1.0
        score[slot, c] = 0.0
        weighed[slot, c] = 0.0
        bank.unlearnt[slot, c] = cov[biases[c], biases[c]]
        for i in range(rows):
            bank.unlearnt[slot, c] += weight[i, biases[c]] ** 2
    bank.onset[slot] = j
    flat = response.reshape(s, size * count)
    signature = np.dot(room.design[:rows], flat)
    for i in range(rows):
        for m in range(i):
            factor = chol[i, m]
            for o in range(flat.shape[1]):
                signature[i, o] -= factor * signature[m, o]
        scale = 1.0 / chol[i, i]
        for o in range(flat.shape[1]):
            signature[i, o] *= scale
    flat -= np.dot(weight[:rows].T.copy(), signature)
    best, best_o, best_c = -1.0, 0, 0
    for o in range(size):
        for c in range(count):
            for i in range(rows):
                value = signature[i, o * count + c]
                score[o, c] += standard[i] * value
                weighed[o, c] += value * value
            evidence = score[o, c] * score[o, c] / max(weighed[o, c], 1e-12)
            if abs(score[o, c]) < bank.wrong_prior * bank.unlearnt[o, c] * weighed[o, c]:
                continue
            if evidence > best:
                best, best_o, best_c = evidence, o, c
    if best <= bank.threshold:
        return jumps
    length = score[best_o, best_c] / weighed[best_o, best_c]
    spread = 1.0 / weighed[best_o, best_c]
    if abs(length) < bank.least[best_c] or jumps >= bank.found.shape[0]:
        return jumps
    bank.found[jumps, 0] = best_c
    bank.found[jumps, 1] = bank.onset[best_o]
    bank.found[jumps, 2] = j
    bank.found[jumps, 3] = length
    bank.found[jumps, 4] = spread
    bank.found[jumps, 5] = best
    for m in range(s):
        for n in range(s):
            cov[m, n] += response[m, best_o, best_c] * response[n, best_o, best_c] * spread
    for m in range(s):
        mean[m] += response[m, best_o, best_c] * length
    response[:] = 0.0
    score[:] = 0.0
    weighed[:] = 0.0
    return jumps + 1


@compiled
def smooth_walk(
    mean: Any, cov: Any, past_cov: Any, ahead_mean: Any, ahead_cov: Any, decay: Any
) -> None:
    """`footcal_cli.core.inference.kalman.smooth_back` from the last update to the first."""
    u, s = mean.shape
    chol = np.empty((s, s))
    reach, gap = np.empty((s, s)), np.empty((s, s))
    for j in range(u - 2, -1, -1):
        chol[:, :] = ahead_cov[j + 1]
        _cholesky(chol, s)
        # reach.T = P⁻¹ Φ Pₖ: forwards, then backwards through the factor
        for m in range(s):
            for n in range(s):
                reach[m, n] = past_cov[j, n, m] * decay[j + 1, m]
        for m in range(s):
            for i in range(m):
                factor = chol[m, i]
                for n in range(s):
                    reach[m, n] -= factor * reach[i, n]
            scale = 1.0 / chol[m, m]
            for n in range(s):
                reach[m, n] *= scale
        for m in range(s - 1, -1, -1):
            for i in range(m + 1, s):
                factor = chol[i, m]
                for n in range(s):
                    reach[m, n] -= factor * reach[i, n]
            scale = 1.0 / chol[m, m]
            for n in range(s):
                reach[m, n] *= scale
        for m in range(s):
            step = mean[j + 1, m] - ahead_mean[j + 1, m]
            for n in range(s):
                mean[j, n] += reach[m, n] * step
        gap[:, :] = cov[j + 1] - ahead_cov[j + 1]
        cov[j] += np.dot(reach.T.copy(), np.dot(gap, reach))
