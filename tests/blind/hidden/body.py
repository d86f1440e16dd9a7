"""What is hidden in the body's own stream."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tests.blind import foreign
from tests.blind.hidden.contract import Act, Injection
from tests.blind.world import GRAVITY_MPS2, Array, Rng, World


def _late(*names: str) -> Act:
    def act(world: World, size: float, rng: Rng) -> World:
        state = rng.bit_generator.state
        late = {}
        for name in names:
            rng.bit_generator.state = state  # one clock: the same jitter on every stream
            late[name] = foreign.jittered_delay(rng, world.body_time_s, world.body[name], size)
        return world.with_body(**late)

    return act


def _lagging(world: World, size: float, rng: Rng) -> World:
    late = {n: foreign.butterworth_lag(world.body_time_s, world.body[n], size) for n in world.body}
    return world.with_body(**late)


def _heading(world: World) -> Array:
    return np.asarray(world.body["yaw_rad"].mean(axis=1))


def in_body(world: World, vector: Array) -> Array:
    yaw = _heading(world)
    x = np.cos(yaw) * vector[0] - np.sin(yaw) * vector[1]
    y = np.sin(yaw) * vector[0] + np.cos(yaw) * vector[1]
    return np.column_stack([x, y, np.full_like(x, vector[2])])


def _com_offset(world: World, size: float, rng: Rng) -> World:
    angle = rng.uniform(0, 2 * np.pi)
    shift = in_body(world, size * np.array([np.cos(angle), np.sin(angle), 0.0]))
    return world.with_body(com_m=world.body["com_m"] - shift)


def _accel_bias(world: World, size: float, rng: Rng) -> World:
    angle = rng.uniform(0, 2 * np.pi)
    shift = in_body(world, size * np.array([np.cos(angle), np.sin(angle), 0.0]))
    return world.with_body(com_acc_mps2=world.body["com_acc_mps2"] + shift)


def _tilt(world: World, size: float, rng: Rng) -> World:
    angle = rng.uniform(0, 2 * np.pi)
    axis = size * np.array([np.cos(angle), np.sin(angle), 0.0])
    felt = world.body["com_acc_mps2"] + [0.0, 0.0, GRAVITY_MPS2]
    turn = in_body(world, axis)
    return world.with_body(com_acc_mps2=world.body["com_acc_mps2"] - np.cross(turn, felt))


def _momentum(world: World, size: float, rng: Rng) -> World:
    return world.with_body(angmom_rate_nm=world.body["angmom_rate_nm"] * (1.0 - size))


def _mass(world: World, size: float, rng: Rng) -> World:
    """The robot's model is too light; its own angular momentum is computed with it too."""
    mass = world.robot["mass_kg"]
    return replace(
        world.with_body(angmom_rate_nm=world.body["angmom_rate_nm"] * (mass - size) / mass),
        robot={**world.robot, "mass_kg": mass - size},
    )


_LEVEL = ("imu_tilt", "accel_bias", "com_offset", "floor_slope", "cell_position")
_LATE = ("delay", "lag", "sensor_lag")
_STREAMS = ("com_m", "com_acc_mps2", "angmom_rate_nm", "feet_m", "yaw_rad")

INJECTIONS = (
    Injection(
        "com_offset/belief",
        "com_offset",
        "walk",
        _com_offset,
        3e-3,
        "m",
        alias=_LEVEL,
        signed=False,
    ),
    # who stands cannot tell a CoM ahead of where it is thought from cells behind their places
    Injection(
        "com_offset/standing",
        "com_offset",
        "stand",
        _com_offset,
        3e-3,
        "m",
        alias=("com_offset", "cell_position"),
        signed=False,
    ),
    Injection(
        "imu_tilt/belief", "imu_tilt", "walk", _tilt, 0.01, "rad", alias=_LEVEL, signed=False
    ),
    Injection(
        "accel_bias/belief",
        "accel_bias",
        "walk",
        _accel_bias,
        0.1,
        "m/s²",
        alias=_LEVEL,
        signed=False,
    ),
    Injection(
        "angular_momentum/belief", "angular_momentum", "walk", _momentum, 0.2, "-", "angmom_loss"
    ),
    Injection(
        "delay/jittered",
        "delay",
        "walk",
        _late(*_STREAMS),
        0.02,
        "s",
        "delay",
        alias=_LATE,
        signed=False,
    ),
    Injection("lag/butterworth", "lag", "walk", _lagging, 0.03, "s", alias=_LATE, signed=False),
    # real, but no drifting walk can show it
    Injection(
        "mass/belief",
        "mass",
        "walk",
        _mass,
        0.3,
        "kg",
        "mass_correction",
        switch=True,
        untestable=True,
    ),
)
