"""The noise of a setting, spread over the states and rows of a walk."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace

import numpy as np

from footcal_cli.core.online.noise import WalkNoise
from footcal_cli.core.online.rows import Rows
from footcal_cli.core.online.soles import Soles
from footcal_cli.core.parameters import FloatArray, IntArray

_LEAST_SHARE = 0.1
"""A correlated error of a cell below this share of its white noise is not worth a state."""


@dataclass(frozen=True)
class Tuned:
    """Noise of B settings spread over the p unknowns, e correlated errors and k rows.

    Parameters
    ----------
    walk
        Variance rate of z per second, shape (B, p).
    slow, slow_s
        Stationary variance and correlation time of the correlated errors, shape (B, e).
    fixed
        How each of them adds to the rows where that is always the same, shape (k, e).
    own
        Unknowns that a channel's own noise adds like, shape (c,); empty where it is negligible.
    own_scale
        Their prior sd, inverted: columns of the rows per unit, shape (c,).
    own_start
        Number of the first state, of p + e, that adds to the rows as `own` does; −1 for none.
    white
        Row variances, shape (B, k).
    shared
        Variances of what several rows share, shape (B, 2): the cells' noise, the stamps' jitter.
    stamps
        Change of each total per second of wrong stamps, shape (u, totals); (0, 0) for none.
    seen
        States that are the channels' slow noise, shape (c,) or (0,).
    soles
        The last correlated errors, which stay as they are until they are drawn anew.
    """

    walk: FloatArray
    slow: FloatArray
    slow_s: FloatArray
    fixed: FloatArray
    own: IntArray
    own_scale: FloatArray
    own_start: int
    white: FloatArray
    shared: FloatArray
    stamps: FloatArray
    seen: IntArray
    soles: Soles

    @property
    def states(self) -> int:
        """Unknowns and correlated errors together, s."""
        return int(self.walk.shape[1] + self.slow.shape[1])

    def part(self, start: int, stop: int) -> Tuned:
        """The same for updates ``start:stop``."""
        cut = slice(start, stop)
        return replace(self, stamps=self.stamps[cut], soles=self.soles.chosen(cut))

    def design(self, update: int, h: FloatArray, at: IntArray) -> FloatArray:
        """H of the rows `at` of one update, from its h (k, p); shape (rows, s)."""
        change = self.soles.columns[update]
        soles = np.zeros((len(h), change.shape[1]))
        soles[: len(change)] = change
        whole = np.concatenate([h[at], self.fixed[at], soles[at]], axis=1)
        if self.own_start >= 0:
            part = slice(self.own_start, self.own_start + self.own.size)
            whole[:, part] = h[at][:, self.own] * self.own_scale
        return whole

    def noise(self, update: int, h: FloatArray, at: IntArray) -> FloatArray:
        """Covariance of the white noise of the rows `at`, shape (B, rows, rows)."""
        i = np.arange(at.size)
        total = np.zeros((self.shared.shape[0], at.size, at.size))
        if self.own.size:
            own = h[at][:, self.own] * self.own_scale
            total += self.shared[:, 0, None, None] * (own @ own.T)
        if self.stamps.size:
            stamp = np.zeros(self.white.shape[1])
            stamp[: self.stamps.shape[1]] = self.stamps[update]
            total += self.shared[:, 1, None, None] * np.outer(stamp[at], stamp[at])
        total[:, i, i] += self.white[:, at]
        return total


def spread(rows: Rows, noise: WalkNoise) -> Tuned:
    """Give every state and row its noise.

    Parameters
    ----------
    rows, noise
        The walk, and one or many settings.
    """
    table = noise.stacked()
    named = {f.name: table[:, i] for i, f in enumerate(fields(WalkNoise))}
    settings, totals = len(table), rows.totals
    sd = np.empty((settings, len(rows.names)))
    for i, name in enumerate(rows.names):
        kind = name.rsplit(".", 1)[-1]
        if kind in ("gain", "scale"):
            sd[:, i] = named["gain_walk"] / rows.prior_sd[i]
        elif kind == "bias" or kind.startswith("offset_f"):
            sd[:, i] = named["bias_walk_n"] / rows.prior_sd[i]
        else:
            sd[:, i] = named["state_walk"]
    force = np.array([name.startswith("f") for name in rows.outputs[:totals]])
    slow = np.where(force, named["force_slow_n"][:, None], named["moment_slow_nm"][:, None])
    white = np.empty((settings, len(rows.outputs)))
    white[:, :totals] = np.where(force, named["force_n"][:, None], named["moment_nm"][:, None])
    white[:, totals:] = named["swing_n"][:, None] * rows.swing_sd_factor
    slow, white[:, :totals] = (part * rows.total_sd_factor for part in (slow, white[:, :totals]))
    slow_s = np.where(force, named["force_slow_s"][:, None], named["moment_slow_s"][:, None])
    k = len(rows.outputs)
    none: IntArray = np.zeros(0, dtype=np.int64)
    own = none if rows.own is None else rows.own
    p, identity = len(rows.names), np.eye(k)
    fixed, seen, own_start = [identity[:, :totals]], none, -1
    for name in ("swing_slow_n", "swing_fixed_n"):
        if not np.any(named[name] > _LEAST_SHARE * named["swing_n"]):
            continue
        adds = identity[:, totals:]
        if name == "swing_slow_n" and rows.own is not None:
            own_start = p + slow.shape[1]
            seen = own_start + np.arange(k - totals)
            adds = np.zeros((k, k - totals))
        time_s = named[name.removesuffix("n") + "s"]
        kept = named[name][:, None] * rows.swing_sd_factor
        slow = np.concatenate([slow, kept], axis=1)
        slow_s = np.concatenate([slow_s, np.tile(time_s[:, None], kept.shape[1])], axis=1)
        fixed.append(adds)
    if rows.own is not None:
        white[:, totals:] = 0.0
    soles = rows.soles or Soles.none(len(rows), totals)
    shifts = np.tile(named["sole_m"][:, None], soles.renewed.shape[1])
    slow = np.concatenate([slow, shifts], axis=1)
    slow_s = np.concatenate([slow_s, np.full(shifts.shape, np.inf)], axis=1)
    return Tuned(
        walk=sd**2,
        slow=slow**2,
        slow_s=slow_s,
        fixed=np.concatenate(fixed, axis=1),
        own=own,
        own_scale=1.0 / rows.prior_sd[own],
        own_start=own_start,
        white=white**2,
        shared=np.stack([named["swing_n"], named["jitter_s"]], axis=1) ** 2,
        stamps=np.zeros((0, 0)) if rows.per_stamp_s is None else rows.per_stamp_s,
        seen=seen,
        soles=soles,
    )
