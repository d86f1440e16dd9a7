"""The Kalman step of `footcal_cli.core.inference.kalman` in loops over a walk, for a compiler.

`footcal_cli.core.online.filter` and its array code give the same answers, slower, where there is
no compiler (`footcal_cli.core.online.loops`).
"""

from __future__ import annotations

from typing import Any

import numpy as np

from footcal_cli.core.online.loops import compiled

_LOG_2PI = 1.8378770664093453


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
def _rows_at(
    j: int, at: Any, rows: int, h: Any, fixed: Any, own_start: int, own: Any, own_scale: Any,
    out: Any,
) -> None:  # fmt: skip
    """H of the valid rows of update j, states of the correlated errors included."""
    p = h.shape[2]
    for i in range(rows):
        r = at[i]
        for m in range(p):
            out[i, m] = h[j, r, m]
        for m in range(fixed.shape[1]):
            out[i, p + m] = fixed[r, m]
        if own_start >= 0:
            for m in range(own.size):
                out[i, own_start + m] = h[j, r, own[m]] * own_scale[m]


@compiled
def _innovate(
    j: int, at: Any, rows: int, hh: Any, mean: Any, cov: Any, error: Any, white: Any, shared: Any,
    h: Any, own: Any, own_scale: Any, stamps: Any, totals: int, huber: float, nu: Any, total: Any,
    weight: Any, standard: Any, variance: Any,
) -> float:  # fmt: skip
    """Fill ν, L (in `total`), W, z and the variances of update j; ln det S."""
    s = mean.size
    for i in range(rows):
        value = error[j, at[i]]
        for m in range(s):
            value += hh[i, m] * mean[m]
        nu[i] = -value
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
            if stamps.shape[0] > 0 and r < totals and q < totals:
                value += shared[1] * stamps[j, r] * stamps[j, q]
            if i == k:
                value += white[r]
                variance[i] = value
                value = max(value, nu[i] * nu[i] / (huber * huber))
            total[i, k] = value
    log_det = _cholesky(total, rows)
    for i in range(rows):
        value = nu[i]
        for m in range(i):
            factor = total[i, m]
            value -= factor * standard[m]
            for n in range(s):
                weight[i, n] -= factor * weight[m, n]
        scale = 1.0 / total[i, i]
        standard[i] = value * scale
        for n in range(s):
            weight[i, n] *= scale
    return log_det


@compiled
def _correct(mean: Any, cov: Any, weight: Any, standard: Any, rows: int) -> None:
    """``x̂ + Wᵀ z`` and ``P − Wᵀ W`` in place."""
    s = mean.size
    for i in range(rows):
        z = standard[i]
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
    mean: Any, cov: Any, h: Any, error: Any, valid: Any, fixed: Any, own_start: int, own: Any,
    own_scale: Any, stamps: Any, totals: int, interval: Any, opened: Any, walk: Any, slow: Any,
    slow_s: Any, white: Any, shared: Any, huber: float, seen: Any, keep: bool, values: Any,
    momentary: Any,
) -> Any:  # fmt: skip
    """Filter a walk with B settings of the noise, one after another; ln likelihood of each."""
    b, p = walk.shape
    u, k = error.shape
    s = mean.size
    result = np.zeros(b)
    x, cx = np.empty(s), np.empty((s, s))
    at, hh = np.empty(k, np.int64), np.zeros((k, s))
    nu, standard, variance = np.empty(k), np.empty(k), np.empty(k)
    total, weight = np.empty((k, k)), np.empty((k, s))
    decay, drive = np.ones(s), np.empty(s)
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
                d = np.exp(-interval[j] / slow_s[setting, e])
                decay[p + e] = d
                drive[p + e] = slow[setting, e] * (1.0 - d * d)
            _predict(x, cx, decay, drive)
            rows = _valid_at(valid, j, at)
            if rows > 0:
                _rows_at(j, at, rows, h, fixed, own_start, own, own_scale, hh)
                log_det = _innovate(
                    j, at, rows, hh, x, cx, error, white[setting], shared[setting], h, own,
                    own_scale, stamps, totals, huber, nu, total, weight, standard, variance,
                )  # fmt: skip
                nis = 0.0
                for i in range(rows):
                    nis += standard[i] * standard[i]
                likelihood -= 0.5 * (nis + log_det + rows * _LOG_2PI)
                _correct(x, cx, weight, standard, rows)
            if keep:
                for m in range(p):
                    values[j, setting, m] = x[m]
                for m in range(seen.size):
                    momentary[j, setting, m] = x[seen[m]]
        result[setting] = likelihood
    return result


@compiled
def filter_walk(
    mean: Any, cov: Any, h: Any, error: Any, valid: Any, fixed: Any, own_start: int, own: Any,
    own_scale: Any, stamps: Any, totals: int, decays: Any, drives: Any, white: Any, shared: Any,
    huber: float, least_gain: float, seen: Any, values: Any, variances: Any, momentary: Any,
    nis: Any, gains: Any, innovation: Any, innovation_var: Any, used: Any, past_mean: Any,
    past_cov: Any, ahead_mean: Any, ahead_cov: Any, biases: Any, response: Any, score: Any,
    weighed: Any, onset: Any, unlearnt: Any, threshold: float, least: Any, wrong_prior: float,
    found: Any,
) -> Any:  # fmt: skip
    """Filter a walk with one setting; the bank of jumps along, where `biases` has any.

    `mean` and `cov` are left as after the last update. Returns ln likelihood and number of jumps.
    """
    u, k = error.shape
    s, p = mean.size, h.shape[2]
    at, hh = np.empty(k, np.int64), np.zeros((k, s))
    nu, standard, variance = np.empty(k), np.empty(k), np.empty(k)
    total, weight = np.empty((k, k)), np.empty((k, s))
    before, after = np.empty((p, p)), np.empty((p, p))
    likelihood, jumps = 0.0, 0
    history = past_mean.shape[0] > 0
    for j in range(u):
        _predict(mean, cov, decays[j], drives[j])
        if history:
            ahead_mean[j] = mean
            ahead_cov[j] = cov
        rows = _valid_at(valid, j, at)
        if rows > 0:
            _rows_at(j, at, rows, h, fixed, own_start, own, own_scale, hh)
            log_det = _innovate(
                j, at, rows, hh, mean, cov, error, white, shared, h, own, own_scale, stamps,
                totals, huber, nu, total, weight, standard, variance,
            )  # fmt: skip
            for i in range(rows):
                innovation[j, at[i]] = nu[i]
                innovation_var[j, at[i]] = variance[i]
                nis[j] += standard[i] * standard[i]
            likelihood -= 0.5 * (nis[j] + log_det + rows * _LOG_2PI)
            gains[j] = _taught(cov, weight, rows, p, before, after)
            if gains[j] > least_gain:
                used[j] = True
                _correct(mean, cov, weight, standard, rows)
                if biases.size > 0:
                    jumps = _jump(
                        j, rows, hh, total, weight, standard, decays[j], mean, cov, biases,
                        response, score, weighed, onset, unlearnt, threshold, least, wrong_prior,
                        found, jumps,
                    )  # fmt: skip
        for m in range(p):
            values[j, m] = mean[m]
            variances[j, m] = cov[m, m]
        for m in range(seen.size):
            momentary[j, m] = mean[seen[m]]
        if history:
            past_mean[j] = mean
            past_cov[j] = cov
    return likelihood, jumps


@compiled
def _jump(
    j: int, rows: int, hh: Any, chol: Any, weight: Any, standard: Any, decay: Any, mean: Any,
    cov: Any, biases: Any, response: Any, score: Any, weighed: Any, onset: Any, unlearnt: Any,
    threshold: float, least: Any, wrong_prior: float, found: Any, jumps: int,
) -> int:  # fmt: skip
    """`footcal_cli.core.online.jumps.JumpBank.update`; how many jumps have been found."""
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
        unlearnt[slot, c] = cov[biases[c], biases[c]]
        for i in range(rows):
            unlearnt[slot, c] += weight[i, biases[c]] ** 2
    onset[slot] = j
    flat = response.reshape(s, size * count)
    signature = np.dot(hh[:rows], flat)
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
            if abs(score[o, c]) < wrong_prior * unlearnt[o, c] * weighed[o, c]:
                continue
            if evidence > best:
                best, best_o, best_c = evidence, o, c
    if best <= threshold:
        return jumps
    length = score[best_o, best_c] / weighed[best_o, best_c]
    spread = 1.0 / weighed[best_o, best_c]
    if abs(length) < least[best_c] or jumps >= found.shape[0]:
        return jumps
    found[jumps, 0] = best_c
    found[jumps, 1] = onset[best_o]
    found[jumps, 2] = j
    found[jumps, 3] = length
    found[jumps, 4] = spread
    found[jumps, 5] = best
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
