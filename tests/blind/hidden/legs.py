"""What is hidden in six-axis transducers."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from tests.blind import foreign
from tests.blind.hidden.contract import Act, Injection, Mask
from tests.blind.world import GRAVITY_MPS2, Array, Rng, World

_AXIS_SIZE = np.array([1, 1, 1, 0.06, 0.06, 0.06])


def _one_leg(world: World, rng: Rng) -> tuple[Mask, int]:
    """Rows of one drawn leg, and its first column."""
    if world.experiment == "hang":
        leg = int(rng.integers(int(world.row["leg"].max()) + 1))
        return np.asarray(world.row["leg"] == leg), 0
    leg = int(rng.integers(6))
    return np.ones(world.time_s.size, dtype=bool), 6 * leg


def _legwise(change: Callable[[World, float, Rng, Mask, Array], Array]) -> Act:
    """What is added to the six readings of one leg, shape (rows, 6)."""

    def act(world: World, size: float, rng: Rng) -> World:
        rows, first = _one_leg(world, rng)
        shown = world.shown.copy()
        wrench = shown[rows, first : first + 6]
        shown[rows, first : first + 6] = wrench + change(world, size, rng, rows, wrench)
        return world.with_shown(shown)

    return act


def _gain(world: World, size: float, rng: Rng, rows: Mask, wrench: Array) -> Array:
    return np.asarray(size * wrench * (np.arange(6) == rng.choice([0, 2])))


def _coupling(world: World, size: float, rng: Rng, rows: Mask, wrench: Array) -> Array:
    source = rng.choice([0, 2])  # gravity never lies along y when hanging
    to = rng.choice([axis for axis in range(3) if axis != source])
    return np.asarray(size * wrench[:, [source]] * (np.arange(6) == to))


def _axis_turned(world: World, size: float, rng: Rng, rows: Mask, wrench: Array) -> Array:
    return np.asarray(-2.0 * wrench * (np.arange(6) == rng.choice([0, 2])))


def _phase(world: World, rows: Mask, columns_leg: int) -> Array:
    phase = world.row["phase_rad"]
    return np.asarray(phase[rows] if phase.ndim == 1 else phase[rows, columns_leg])


def _cable(world: World, size: float, rng: Rng) -> World:
    """A cable as a spring between a post and the shank: its pull turns with the shaft."""
    rows, first = _one_leg(world, rng)
    phase = _phase(world, rows, first // 6)
    post = rng.uniform(0, 2 * np.pi)
    reach = np.stack([np.cos(phase) - 2 * np.cos(post), np.sin(phase) - 2 * np.sin(post)], -1)
    length = np.linalg.norm(reach, axis=1, keepdims=True)
    pull = -size * (length - 0.8) * reach / length
    shown = world.shown.copy()
    shown[rows, first] += pull[:, 0]
    shown[rows, first + 2] += pull[:, 1]
    return world.with_shown(shown)


def _hang_drift(world: World, size: float, rng: Rng, rows: Mask, wrench: Array) -> Array:
    since = world.time_s[rows] - world.time_s[rows].min()
    return np.asarray(size * since[:, None] * (np.arange(6) == rng.integers(3)))


def _hang_warm(world: World, size: float, rng: Rng, rows: Mask, wrench: Array) -> Array:
    degc = world.row["temperature_degc"][rows]
    felt = foreign.thermal_lag(degc, world.time_s[rows], world.fresh[rows], rng.uniform(5.0, 20.0))
    return np.asarray(size * (felt - 25.0)[:, None] * (np.arange(6) == rng.integers(3)))


def _hang_step(world: World, size: float, rng: Rng, rows: Mask, wrench: Array) -> Array:
    time_s = world.time_s[rows]
    at = time_s.min() + rng.uniform(0.3, 0.7) * np.ptp(time_s)
    return np.asarray(
        size * (time_s >= at)[:, None] * (np.arange(6) == rng.integers(6)) * _AXIS_SIZE
    )


def _bearing(world: World, size: float, rng: Rng, rows: Mask, wrench: Array) -> Array:
    """A rough bearing: torque that catches and lets go a few times per turn."""
    phase = world.row["phase_rad"][rows]
    teeth = int(rng.integers(5, 9))
    saw = (teeth * phase / (2 * np.pi)) % 1.0 - 0.5
    return np.asarray(size * saw[:, None] * (np.arange(6) == 4))


def _hang_hum(world: World, size: float, rng: Rng, rows: Mask, wrench: Array) -> Array:
    return np.asarray(foreign.mains_hum(rng, world.time_s[rows], size, 6) * _AXIS_SIZE)


def _hang_tug(world: World, size: float, rng: Rng, rows: Mask, wrench: Array) -> Array:
    pull = foreign.cable_tug(rng, world.time_s[rows], world.fresh[rows], size)
    direction = rng.normal(size=6) * _AXIS_SIZE
    return np.asarray(pull[:, None] * direction / np.linalg.norm(direction[:3]))


def _sole(world: World, size: float, rng: Rng, rows: Mask, wrench: Array) -> Array:
    """A foot that folds sideways: part of the lateral force is lost where it is large."""
    lateral = wrench[:, 1] - np.median(wrench[:, 1])
    return np.asarray(-size * np.abs(lateral)[:, None] * (np.arange(6) == 1))


def _strain(world: World, size: float, rng: Rng, rows: Mask, wrench: Array) -> Array:
    """The case gives: part of the vertical load of a leg passes beside its transducer."""
    return np.asarray(-size * wrench * np.array([0.0, 0.0, 1.0, 0.0, 0.0, 0.0]))


def _robot_weight(world: World, size: float, rng: Rng) -> World:
    mass = world.robot["mass_kg"] - size / GRAVITY_MPS2
    chassis = world.row["chassis_n"] - size
    return replace(world.with_row(chassis_n=chassis), robot={**world.robot, "mass_kg": mass})


def _shoe(world: World, size: float, rng: Rng) -> World:
    """One leg hung without its shoe: the hanging log is too light by what stands in the poses."""
    legs = world.facts["legs"]
    leg = int(rng.integers(6))
    weight = [w - size * (k == leg) for k, w in enumerate(legs["weight_n"])]
    facts = {**world.facts, "legs": {**legs, "weight_n": weight}}
    changed = world.with_row(chassis_n=world.row["chassis_n"] + size)
    return replace(changed, facts=facts)


def _body_marker(world: World, size: float, rng: Rng) -> World:
    """Markers turned on the body: what motion capture calls the body's attitude is off by it."""
    angle = rng.uniform(0, 2 * np.pi)
    turn = Rotation.from_rotvec(size * np.array([np.cos(angle), np.sin(angle), 0.0]))
    attitude = Rotation.from_rotvec(world.row["tilt"]) * turn
    down = attitude.inv().apply([0.0, 0.0, -1.0])
    return world.with_row(tilt=attitude.as_rotvec(), down_b=down)


_WEIGHTS = ("robot_weight", "leg_weight")
_GAINS = ("scale_matrix", "case_strain")

INJECTIONS = (
    Injection("scale_matrix/axis", "scale_matrix", "hang", _legwise(_gain), 0.02, "-"),
    # a share of one axis lost beside the transducer or in its gain is the same in every pose
    Injection(
        "scale_matrix/standing",
        "scale_matrix",
        "pose",
        _legwise(_gain),
        0.02,
        "-",
        alias=_GAINS,
        most=0.4,
    ),
    Injection("cross_coupling/pair", "cross_coupling", "hang pose", _legwise(_coupling), 0.02, "-"),
    Injection("cable_drag/spring", "cable_drag", "hang pose", _cable, 0.1, "N"),
    Injection("offset_drift/linear", "offset_drift", "hang", _legwise(_hang_drift), 1e-4, "N/s"),
    Injection("offset_change/step", "offset_change", "hang", _legwise(_hang_step), 0.1, "N"),
    Injection(
        "temperature_bias/leg", "temperature_bias", "hang", _legwise(_hang_warm), 0.02, "N/K"
    ),
    Injection(
        "case_strain/vertical",
        "case_strain",
        "pose",
        _legwise(_strain),
        0.05,
        "-",
        alias=_GAINS,
        most=0.4,
    ),
    Injection(
        "robot_weight/belief",
        "robot_weight",
        "pose",
        _robot_weight,
        1.0,
        "N",
        alias=_WEIGHTS,
        most=25.0,
    ),
    # a leg without its shoe weighs something: the lightest 4 N
    Injection("leg_weight/shoe", "leg_weight", "pose", _shoe, 0.5, "N", alias=_WEIGHTS, most=3.0),
    Injection(
        "body_tilt/marker",
        "body_tilt",
        "pose",
        _body_marker,
        0.02,
        "rad",
        switch=True,
        untestable=True,
    ),
    Injection(
        "axis_flip/wires",
        "axis_flip sign_flip",
        "hang pose",
        _legwise(_axis_turned),
        1.0,
        switch=True,
    ),
    Injection("unseen/rough_bearing", "", "hang", _legwise(_bearing), 0.01),
    Injection("unseen/leg_hum", "", "hang", _legwise(_hang_hum), 0.05),
    Injection("unseen/leg_tug", "", "hang", _legwise(_hang_tug), 0.1),
    Injection("unseen/folding_sole", "", "pose", _legwise(_sole), 0.1),
)
