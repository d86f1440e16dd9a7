"""Signatures of every other effect that a library could name, by formulas of the bench's own.

An effect is tried in each cell (axis, foot, hole, label) alone and, where an effect of the bench
can be everywhere, in all of them; shapes on a short grid; effects with a direction as two columns.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from tests.blind import foreign
from tests.blind.hidden.body import in_body
from tests.blind.rivals_legs import leg_rivals
from tests.blind.whitening import Inputs
from tests.blind.world import GRAVITY_MPS2, Array, World
from tests.blind.yardstick import Yardstick

Rival = tuple[str, list[Array]]
"""Name, and the changes of the errors that are fitted together, each of shape (n, k)."""

ONE_WAY = ("hysteresis", "load_bypass", "saturation")
"""What takes load or energy and never gives any: their signatures are not fitted with a minus."""
HINGES = (0.1, 0.2, 0.4, 0.6, 0.8)
LIMITS = (0.25, 0.5, 0.7, 0.85, 0.95)
DEAF = (0.05, 0.1, 0.2, 0.4)
"""Knees of footcal's sharp curves, as shares of the span."""
SOFT = (0.3, 0.4, 0.5, 0.6)
"""Knees of the bench's own rounded ones, which single cells may have."""
REACHES = (0.05, 0.12, 0.3, 0.6)
TIMES_S = (6.0, 20.0, 60.0, 180.0)
STEPS_AT = (0.25, 0.5, 0.75)
DELAY_S = 0.01
_AXES = np.eye(3)


def rivals(clean: World, stick: Yardstick, inputs: Inputs) -> Iterator[Rival]:
    """All rivals in an experiment."""
    if clean.experiment in ("hang", "pose"):
        yield from leg_rivals(clean, inputs)
        return
    yield from _in_cells(clean, inputs)
    if "load_n" in clean.row:
        yield from _beliefs(clean, stick)
    if clean.experiment != "weights":
        yield from _in_feet(clean, inputs)
        yield from _misplaced(clean, stick)
    if clean.experiment in ("walk", "stand"):
        yield from _body(clean, stick)
    if clean.experiment == "walk":
        yield from _telemetry(clean, stick)


def sharp_curves(load: Array, span: float) -> Iterator[tuple[str, Array]]:
    """What memoryless distortions of footcal's table add to loads of any shape, per unit."""
    yield "nonlinearity", load**2
    yield "nonlinearity_cubic", load**3
    for knee in span * np.array(LIMITS):
        yield "saturation", np.clip(load, -knee, knee) - load
    for knee in span * np.array(DEAF):
        yield "dead_zone", np.clip(load, -knee, knee)
    for knee in span * np.array(HINGES):
        yield "hinge", np.maximum(load - knee, 0.0)


def soft_curves(load: Array, span: float) -> Iterator[tuple[str, Array]]:
    """The bench's own where it hides others than the table's."""
    yield "saturation", span * np.tanh(load / span) - load
    for knee in span * np.array(SOFT):
        yield "dead_zone", knee * np.tanh(load / knee)
        yield "hinge", 0.08 * knee * np.logaddexp(0.0, (load - knee) / (0.08 * knee))


def memories(load: Array, clean: World) -> Iterator[tuple[str, Array]]:
    """What play and creep add, shape (n, c)."""
    reaches = clean.span_n * np.repeat(REACHES, load.shape[1])
    decay = np.exp(-np.diff(clean.time_s, prepend=0.0)[:, None] / np.repeat(TIMES_S, load.shape[1]))
    play, slow = np.zeros((2, len(load), reaches.size))
    wide = np.tile(load, (1, len(REACHES)))
    for i, fresh in enumerate(clean.fresh):
        if fresh:
            play[i] = wide[i]
        else:
            play[i] = np.clip(play[i - 1], wide[i] - reaches, wide[i] + reaches)
            slow[i] = wide[i] + (slow[i - 1] - wide[i]) * decay[i]
    for part in np.split(np.arange(reaches.size), len(REACHES)):
        yield "hysteresis", (play[:, part] - load) / reaches[part]
        yield "creep", slow[:, part]


def _in_cells(clean: World, inputs: Inputs) -> Iterator[Rival]:
    """In one cell or in all alike."""
    for name, added in _added(clean, inputs):
        single = [
            column[:, None] * reach for column, reach in zip(added.T, inputs.reach, strict=True)
        ]
        yield from ((name, [column]) for column in single)
        yield name, [np.sum(single, axis=0)]


def _added(clean: World, inputs: Inputs) -> Iterator[tuple[str, Array]]:
    """What is added to each input, shape (n, inputs)."""
    load, ones = inputs.load, np.ones_like(inputs.load)
    yield from sharp_curves(load, clean.span_n)
    if clean.experiment == "weights":
        yield from soft_curves(load, clean.span_n)
    since = clean.time_s - clean.time_s.min()
    yield "bias_drift", since[:, None] * ones
    order = np.arange(since.size) / since.size
    for share in STEPS_AT:
        yield "bias_jump", (order >= share)[:, None] * ones
    if clean.experiment != "placements":
        shown = clean.shown if clean.shown.shape[1] > 1 else clean.shown.repeat(load.shape[1], 1)
        yield from memories(shown, clean)
        warm = clean.row["temperature_degc"][:, None] - 25.0
        yield "temperature_bias", warm * ones
        yield "temperature_scale", warm * load
    if clean.experiment == "walk":
        yield "sensor_lag", -np.gradient(clean.shown, clean.time_s, axis=0)
    if clean.experiment != "weights":
        for before in (0, 1, 2, 3):
            yield "crosstalk", _heard(load, before)


def _heard(load: Array, before: int) -> Array:
    """What each cell hears of its foot's other three, or of the one so many places before it."""
    feet = load.reshape(len(load), -1, 4)
    heard = np.roll(feet, before, axis=2) if before else (feet.sum(2, keepdims=True) - feet) / 3.0
    return np.asarray(heard.reshape(load.shape))


def _beliefs(clean: World, stick: Yardstick) -> Iterator[Rival]:
    """Labels and holes."""
    load = clean.row["load_n"]
    for label in np.unique(load[load > 0]):
        moved = clean.with_row(load_n=load + (load == label))
        yield "wrong_weight", [_changed(stick, moved)]
    if clean.experiment == "placements":
        for hole in np.unique(clean.row["hole"]):
            chosen = (clean.row["hole"] == hole)[:, None]
            shifts = (1e-3 * chosen * axis[:2] for axis in _AXES[:2])
            yield (
                "wrong_hole",
                [_changed(stick, clean.with_row(hole_m=clean.row["hole_m"] + s)) for s in shifts],
            )


def _in_feet(clean: World, inputs: Inputs) -> Iterator[Rival]:
    """What acts on a foot as a whole."""
    feet = [np.flatnonzero(inputs.owner == foot) for foot in np.unique(inputs.owner)]
    total = np.stack([inputs.load[:, cells].sum(axis=1) for cells in feet], axis=1)
    touches = total.max() * np.array((0.0, *HINGES[1:]))
    for touch in touches:
        width = 0.15 * touch + 0.2
        soft = width * np.logaddexp(0.0, (total - touch) / width)
        for beside in (np.maximum(total - touch, 0.0), soft)[: 1 + (clean.experiment != "stand")]:
            share = -beside / np.maximum(total, 1e-6)
            single = [
                np.einsum("n,nc,cnk->nk", share[:, f], inputs.load[:, cells], inputs.reach[cells])
                for f, cells in enumerate(feet)
            ]
            yield from (("load_bypass", [column]) for column in single)
            yield "load_bypass", [np.sum(single, axis=0)]
    if clean.experiment == "walk":
        for foot, cells in enumerate(feet):
            hung = (clean.row["swing"][:, foot] == 1.0) / -len(cells)
            yield "hanging_plate", [np.einsum("n,cnk->nk", hung, inputs.reach[cells])]


def _misplaced(clean: World, stick: Yardstick) -> Iterator[Rival]:
    """Each cell elsewhere than thought, in the axes of its foot."""
    key = "cell_pos_m" if "cell_pos_m" in clean.row else "cells_m"
    for cell in range(clean.row[key].shape[1]):
        moved = []
        for axis in range(2):
            places = clean.row[key].copy()
            places[:, cell, axis] += 1e-3
            moved.append(_changed(stick, clean.with_row(**{key: places})))
        yield "cell_position", moved


def _body(clean: World, stick: Yardstick) -> Iterator[Rival]:
    """Mass, CoM and feet; of a walk also its inertial unit and the floor."""
    body, mass = clean.body, float(clean.robot["mass_kg"])
    lighter = replace(
        clean.with_body(angmom_rate_nm=body["angmom_rate_nm"] * (mass - 0.1) / mass),
        robot={**clean.robot, "mass_kg": mass - 0.1},
    )
    yield "mass", [_changed(stick, lighter)]
    shifts = [1e-3 * in_body(clean, axis) for axis in _AXES]
    moved = [_changed(stick, clean.with_body(com_m=body["com_m"] + shift)) for shift in shifts]
    yield "com_offset", moved[:2]
    yield "com_offset", moved[2:]
    for foot in range(2):
        for share in STEPS_AT:
            since = clean.body_time_s >= share * clean.body_time_s[-1]
            slid = []
            for axis in range(2):
                feet = body["feet_m"].copy()
                feet[since, foot, axis] += 1e-3
                slid.append(_changed(stick, clean.with_body(feet_m=feet)))
            yield "slip", slid
    if clean.experiment == "walk":
        yield from _inertial(clean, stick)


def _inertial(clean: World, stick: Yardstick) -> Iterator[Rival]:
    acc = clean.body["com_acc_mps2"]
    felt = acc + GRAVITY_MPS2 * _AXES[2]

    def change(added: Array) -> Array:
        return _changed(stick, clean.with_body(com_acc_mps2=acc + added))

    biases = [change(0.01 * in_body(clean, axis)) for axis in _AXES]
    yield "accel_bias", biases[:2]
    yield "accel_bias", biases[2:]
    turns = [1e-3 * axis for axis in _AXES[:2]]
    yield "imu_tilt", [change(np.cross(in_body(clean, turn), felt)) for turn in turns]
    yield "floor_slope", [change(np.cross(np.broadcast_to(t, felt.shape), felt)) for t in turns]
    rate = clean.body["angmom_rate_nm"]
    yield "angular_momentum", [_changed(stick, clean.with_body(angmom_rate_nm=0.9 * rate))]


def _telemetry(clean: World, stick: Yardstick) -> Iterator[Rival]:
    """The body's stream late, smoothed, or by a clock that runs at another rate."""
    time_s = clean.body_time_s

    def late(delay_s: Array) -> Array:
        then = time_s - delay_s
        streams = {}
        for name, values in clean.body.items():
            flat = values.reshape(time_s.size, -1)
            columns = [np.interp(then, time_s, column) for column in flat.T]
            streams[name] = np.stack(columns, axis=1).reshape(values.shape)
        return _changed(stick, clean.with_body(**streams))

    yield "delay", [late(np.full(time_s.size, DELAY_S))]
    yield "clock_drift", [late(DELAY_S * time_s / time_s[-1])]
    lagging = {
        name: foreign.butterworth_lag(time_s, values, 3 * DELAY_S)
        for name, values in clean.body.items()
    }
    yield "lag", [_changed(stick, clean.with_body(**lagging))]


def _changed(stick: Yardstick, world: World) -> Array:
    return np.nan_to_num(stick.maker.error(world) - stick.clean_error)
