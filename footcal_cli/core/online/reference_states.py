"""What may be wrong with the force and CoP that a motion demands, and what each changes of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from footcal_cli.core.centroidal import Reference, pressure
from footcal_cli.core.effects.body import COM_OFFSET, heading_rad
from footcal_cli.core.effects.transport import DELAY, SMOOTHED_OVER_S, SMOOTHING
from footcal_cli.core.experiments import walk
from footcal_cli.core.log import Log
from footcal_cli.core.online.belief import Belief
from footcal_cli.core.parameters import FloatArray

REFERENCE_STATES: Mapping[str, tuple[str, float]] = {
    "robot.delay": ("s", 0.01),
    "robot.com_correction_x": ("m", 0.004),
    "robot.com_correction_y": ("m", 0.004),
    "robot.com_correction_z": ("m", 0.004),
    "robot.angmom_loss": ("-", 0.2),
    "robot.angmom_share_x": ("-", 0.5),
    "robot.angmom_share_y": ("-", 0.5),
    "robot.smoothing": ("s²", 5e-4),
    "robot.smoothing_fourth": ("s⁴", 1e-6),
}
"""What may be wrong with the demanded force and CoP -> unit and prior sd; names as in effects."""
MOMENTUM_SHARES = ("robot.angmom_share_x", "robot.angmom_share_y")
"""Where a stream has no rate of angular momentum, limbs still swing as the body is pushed:
``(L̇ʸ, −L̇ˣ) = s m cᶻ c̈``, s one share along and one across the heading. The state is
σ = s / (1 + s), in which the demanded CoP is linear: ``c − p = (1 + s) m cᶻ c̈ / Fz``."""
HINDSIGHT_STATES = {
    "robot.com_correction_z": COM_OFFSET,
    "robot.smoothing": SMOOTHING,
    "robot.smoothing_fourth": SMOOTHING,
}
"""States that only a whole walk determines -> the effect that they are a size of."""


def advanced(log: Log, delay_s: float) -> Log:
    """The log with its body stream moved earlier by a delay that was found."""
    if delay_s == 0.0:
        return log
    moved, _ = DELAY.remove(log, {DELAY.size.name: np.array([delay_s])}, None)
    return moved


def reference_slopes(
    log: Log,
    reference: Reference,
    belief: Belief,
    states: Sequence[str],
    sd: Mapping[str, float],
    *,
    static: bool,
) -> dict[str, FloatArray]:
    """``∂(Fz, pˣ, pʸ)/∂state`` of the reference, (n, 3): the delay's, and those of the states.

    Parameters
    ----------
    log
        Raw counts.
    sd
        Prior sd of the states: how far each is moved.
    """
    slopes = {"robot.delay": _slope(log.time_s, reference)} | {
        name: _changed(name, sd[name], log, belief, static=static)
        for name in states
        if name in HINDSIGHT_STATES
    }
    if set(MOMENTUM_SHARES) & set(states):
        slopes |= dict(zip(MOMENTUM_SHARES, _of_momentum(log, belief), strict=True))
    return slopes


def _slope(time_s: FloatArray, reference: Reference) -> FloatArray:
    """Time derivative of (Fz, pˣ, pʸ) of the reference, shape (n, 3); 0 where it breaks off."""
    series = np.column_stack([reference.fz_n, reference.cop_m])
    if len(series) < 2:
        return np.zeros_like(series)
    slope = np.gradient(series, time_s, axis=0)
    return np.where(np.isfinite(slope), slope, 0.0)


def _as_cells_have_it(log: Log, belief: Belief) -> Log:
    """The log with the acceleration that the measured force and CoP stand for.

    A noisy acceleration times a size is correlated with the noise of the reference: regressed on
    it, smoothing and the height of the CoM come out too small, or negative (errors in variables).
    The cells' noise is independent of it. The rate of angular momentum in the stream is no more
    exact, and its error is treated as noise of the acceleration.
    """
    forces, known = belief.forces(log.readings), log.known
    fz, com = forces.sum(axis=1), known["com_m"]
    moment = np.einsum("nca,nc->na", known["cell_pos_m"], forces)
    with np.errstate(divide="ignore", invalid="ignore"):
        level = (com[:, :2] * fz[:, None] - moment) / (known["mass_kg"] * com[:, 2])[:, None]
        level = np.where(np.isfinite(level), level, np.nan)  # a CoM on the floor
    up = fz / known["mass_kg"] - known["gravity_mps2"]
    return log.with_known(
        com_acc_mps2=np.column_stack([level, up]),
        angmom_rate_nm=np.zeros_like(known["angmom_rate_nm"]),
    )


def _of_momentum(log: Log, belief: Belief) -> tuple[FloatArray, FloatArray]:
    """``∂(Fz, pˣ, pʸ)/∂σ`` of `MOMENTUM_SHARES`: the measured CoP's way back to the CoM, (n, 3)."""
    forces, known, yaw = belief.forces(log.readings), log.known, heading_rad(log)
    cop = pressure(forces, known["cell_pos_m"], walk.least_force_n(log)).cop_m
    way = np.nan_to_num(known["com_m"][:, :2] - cop)
    ahead = np.stack([np.cos(yaw), np.sin(yaw)], axis=1)
    along = np.sum(way * ahead, axis=1)[:, None] * ahead
    zero = np.zeros((len(log), 1))
    return np.hstack([zero, -along]), np.hstack([zero, along - way])


def _changed(name: str, size: float, log: Log, belief: Belief, *, static: bool) -> FloatArray:
    """``∂(Fz, pˣ, pʸ)/∂state`` of the reference when an effect is removed, shape (n, 3)."""
    effect, log = HINDSIGHT_STATES[name], _as_cells_have_it(log, belief)
    theta = {p: np.zeros(1) for p in effect.parameter_names}
    theta[name.removeprefix("robot.")] = np.array([size])
    without, _ = effect.remove(log, theta, None)
    reference, moved = (walk.reference_of(of, static=static) for of in (log, without))
    change = np.column_stack([moved.fz_n - reference.fz_n, moved.cop_m - reference.cop_m]) / size
    first, last = log.time_s[[0, -1]]
    # a derivative needs samples on both sides
    amid = (log.time_s >= first + SMOOTHED_OVER_S) & (log.time_s <= last - SMOOTHED_OVER_S)
    return np.where(np.isfinite(change) & amid[:, None], change, 0.0)


def state_column(
    name: str, log: Log, slopes: Mapping[str, FloatArray], yaw: FloatArray
) -> FloatArray:
    """``∂(fz, mx, my)/∂state``, shape (n, 3): ``(−∂F_ref, −Fz ∂pʸ, Fz ∂pˣ)``, Fz of the cells."""
    fz = log.readings.sum(axis=1)
    zero = np.zeros_like(fz)
    if name in slopes:
        slope = slopes[name]
        return np.stack([-slope[:, 0], -fz * slope[:, 2], fz * slope[:, 1]], axis=1)
    if name == "robot.com_correction_x":
        return np.stack([zero, -fz * np.sin(yaw), fz * np.cos(yaw)], axis=1)
    if name == "robot.com_correction_y":
        return np.stack([zero, -fz * np.cos(yaw), -fz * np.sin(yaw)], axis=1)
    if name == "robot.angmom_loss":
        return np.stack([zero, *(-log.known["angmom_rate_nm"]).T], axis=1)
    raise KeyError(f"no state '{name}'; known are {', '.join(REFERENCE_STATES)}")
