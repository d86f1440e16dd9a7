"""The sums of the sliding window in loops over a whole walk.

For a compiler (numba).
As `footcal_cli.core.study.window`, where the array code gives the same answers, slower.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from footcal_cli.core.online.loops import compiled

_ANEW = 64
"""Updates after which sliding sums are added up anew, so that rounding does not gather."""


@compiled
def _step(normal: Any, pull: Any, theta: Any, bound: float) -> float:
    """``θ ← θ − clip(N⁻¹ g)`` and the largest ``|N⁻¹ g|``; N's lower triangle and g are lost."""
    p = theta.size
    for i in range(p):
        for j in range(i + 1):
            total = normal[i, j]
            for m in range(j):
                total -= normal[i, m] * normal[j, m]
            if i == j:
                normal[i, i] = np.sqrt(total)
            else:
                normal[i, j] = total / normal[j, j]
    for i in range(p):
        for m in range(i):
            pull[i] -= normal[i, m] * pull[m]
        pull[i] /= normal[i, i]
    for i in range(p - 1, -1, -1):
        for m in range(i + 1, p):
            pull[i] -= normal[m, i] * pull[m]
        pull[i] /= normal[i, i]
    largest = 0.0
    for i in range(p):
        theta[i] -= min(max(pull[i], -bound), bound)
        largest = max(largest, abs(pull[i]))
    return largest


@compiled
def window_exact(
    samples: Any, weights: Any, first: Any, stop: Any, iterations: int, bound: float,
    enough: float, least_n: float, solutions: Any,
) -> None:  # fmt: skip
    """Gauss-Newton on the ratio, eq. (14), `iterations` at most; fills (u, settings, 2c)."""
    believed, positions, fz, cop, unit = samples
    force_w, cop_w, smooth_w = weights
    c = believed.shape[1]
    p = 2 * c
    f, slope_x, slope_y = np.empty(p), np.empty(p), np.empty(p)
    normal, force_normal = np.empty((p, p)), np.empty((p, p))
    pull, previous = np.empty(p), np.empty(p)
    for b in range(force_w.size):
        theta = np.zeros(p)
        for j in range(first.size):
            previous[:] = theta
            known = first[j]
            if j % _ANEW == 0:
                force_normal[:, :] = 0.0
            else:
                known = max(stop[j - 1], first[j])
                for n in range(first[j - 1], min(first[j], stop[j - 1])):
                    _square(believed[n], unit, f, -1.0, force_normal)
            for n in range(known, stop[j]):
                _square(believed[n], unit, f, 1.0, force_normal)
            for _ in range(iterations if stop[j] > first[j] else 0):
                for i in range(p):
                    for k in range(i + 1):
                        normal[i, k] = force_w[b] * force_normal[i, k]
                    normal[i, i] += smooth_w[b]
                    pull[i] = smooth_w[b] * (theta[i] - previous[i])
                for n in range(first[j], stop[j]):
                    _features(believed[n], unit, f)
                    total, moment_x, moment_y = 0.0, 0.0, 0.0
                    for i in range(p):
                        a = i if i < c else i - c
                        force = theta[i] * f[i] + (believed[n, i] if i < c else 0.0)
                        total += force
                        moment_x += force * positions[n, a, 0]
                        moment_y += force * positions[n, a, 1]
                    miss = force_w[b] * (total - fz[n])
                    for i in range(p):
                        pull[i] += miss * f[i]
                    if not total > least_n:
                        continue
                    x, y = moment_x / total, moment_y / total
                    for i in range(p):
                        a = i if i < c else i - c
                        slope_x[i] = (positions[n, a, 0] - x) * f[i] / total
                        slope_y[i] = (positions[n, a, 1] - y) * f[i] / total
                    miss_x, miss_y = cop_w[b] * (x - cop[n, 0]), cop_w[b] * (y - cop[n, 1])
                    for i in range(p):
                        pull[i] += slope_x[i] * miss_x + slope_y[i] * miss_y
                        wx, wy = cop_w[b] * slope_x[i], cop_w[b] * slope_y[i]
                        for k in range(i + 1):
                            normal[i, k] += wx * slope_x[k] + wy * slope_y[k]
                if _step(normal, pull, theta, bound) < enough:
                    break
            for i in range(p):
                solutions[j, b, i] = theta[i]


@compiled
def _square(believed: Any, unit: Any, f: Any, sign: float, normal: Any) -> None:
    """Add ``± f fᵀ`` of one sample to the lower triangle; f is overwritten."""
    _features(believed, unit, f)
    for i in range(f.size):
        for k in range(i + 1):
            normal[i, k] += sign * f[i] * f[k]


@compiled
def _features(believed: Any, unit: Any, out: Any) -> None:
    """``∂F/∂θ`` of one sample: each cell's force for its gain, 1 for its bias, per prior sd."""
    c = believed.size
    for i in range(c):
        out[i] = believed[i] * unit[i]
        out[c + i] = unit[c + i]


@compiled
def window_sums(
    samples: Any, weights: Any, edges: Any, length: int, bound: float, solutions: Any
) -> None:
    """The quadratic window: sums per block of samples slide; fills (blocks, settings, 2c).

    Sums of the blocks of the window lie in a ring; one comes in, one goes out, and once per turn
    the whole is added up anew, so that rounding does not gather.
    """
    believed, positions, fz, cop, unit = samples
    force_w, cop_w, smooth_w = weights
    c = believed.shape[1]
    p, settings = 2 * c, force_w.size
    blocks = edges.size - 1
    ring_ff, ring_mm = np.zeros((length, p, p)), np.zeros((length, p, p))
    ring_f, ring_m = np.zeros((length, p)), np.zeros((length, p))
    ff, mm, pull_f, pull_m = np.zeros((p, p)), np.zeros((p, p)), np.zeros(p), np.zeros(p)
    f, mx, my = np.empty(p), np.empty(p), np.empty(p)
    normal, pull = np.empty((p, p)), np.empty(p)
    theta = np.zeros((settings, p))
    for j in range(blocks):
        slot = j % length
        for i in range(p):
            pull_f[i] -= ring_f[slot, i]
            pull_m[i] -= ring_m[slot, i]
            ring_f[slot, i] = 0.0
            ring_m[slot, i] = 0.0
            for k in range(i + 1):
                ff[i, k] -= ring_ff[slot, i, k]
                mm[i, k] -= ring_mm[slot, i, k]
                ring_ff[slot, i, k] = 0.0
                ring_mm[slot, i, k] = 0.0
        for n in range(edges[j], edges[j + 1]):
            _features(believed[n], unit, f)
            total, miss_x, miss_y = 0.0, 0.0, 0.0
            for i in range(c):
                x = (positions[n, i, 0] - cop[n, 0]) / fz[n]
                y = (positions[n, i, 1] - cop[n, 1]) / fz[n]
                total += believed[n, i]
                miss_x += believed[n, i] * x
                miss_y += believed[n, i] * y
                mx[i], my[i] = f[i] * x, f[i] * y
                mx[c + i], my[c + i] = f[c + i] * x, f[c + i] * y
            miss = total - fz[n]
            for i in range(p):
                ring_f[slot, i] += f[i] * miss
                ring_m[slot, i] += mx[i] * miss_x + my[i] * miss_y
                for k in range(i + 1):
                    ring_ff[slot, i, k] += f[i] * f[k]
                    ring_mm[slot, i, k] += mx[i] * mx[k] + my[i] * my[k]
        if slot == 0:
            ff[:, :] = 0.0
            mm[:, :] = 0.0
            pull_f[:] = 0.0
            pull_m[:] = 0.0
        for o in range(length if slot == 0 else 1):
            s = o if slot == 0 else slot
            for i in range(p):
                pull_f[i] += ring_f[s, i]
                pull_m[i] += ring_m[s, i]
                for k in range(i + 1):
                    ff[i, k] += ring_ff[s, i, k]
                    mm[i, k] += ring_mm[s, i, k]
        for b in range(settings):
            for i in range(p):
                pull[i] = force_w[b] * pull_f[i] + cop_w[b] * pull_m[i]
            for i in range(p):
                for k in range(i + 1):
                    value = force_w[b] * ff[i, k] + cop_w[b] * mm[i, k]
                    normal[i, k] = value
                    pull[i] += value * theta[b, k]
                    if k < i:
                        pull[k] += value * theta[b, i]
                normal[i, i] += smooth_w[b]
            _step(normal, pull, theta[b], bound)
            for i in range(p):
                solutions[j, b, i] = theta[b, i]
