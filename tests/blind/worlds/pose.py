"""A hexapod that stands still in many poses; the ground's share of each leg is drawn."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from scipy.spatial.transform import Rotation

from tests.blind.noise import Spread
from tests.blind.world import GRAVITY_MPS2, Array, Maker, Rng, World
from tests.blind.worlds import hang
from tests.blind.worlds.engine_poses import Poses, engine_poses
from tests.blind.worlds.files import write_log, write_recipe
from tests.blind.worlds.legs import ALL_LEGS, AXES, Legs, draw_legs, legs_of, small_turn, write_hang

ENGINE_SHARE = 0.35
"""Of the robots, how many stand as a physics engine made them."""


def draw(rng: Rng, options: Mapping[str, Any]) -> World:
    """90–150 poses, every third on a tripod: drawn on uneven ground, or the engine's."""
    poses = int(options.get("blocks") or rng.integers(90, 150))
    made = engine_poses(rng, poses) if rng.random() < ENGINE_SHARE else drawn_poses(rng, poses)
    legs, wrench = made.legs, made.wrench
    shown = (wrench + legs.offset).reshape(poses, 36)
    family = str(rng.choice(["white", "heteroscedastic", "block_gain_offset"]))
    sd_n = float(rng.uniform(0.02, 0.08))
    sd = np.tile(sd_n * np.array([1, 1, 1, 0.06, 0.06, 0.06]), 6)
    block = np.arange(poses, dtype=np.int64) // 6
    spread = Spread(family, wrench.reshape(poses, 36), block, sd, 0.1)
    return World(
        experiment="pose",
        channels=tuple(f"{leg}.{axis[:2]}" for leg in ALL_LEGS for axis in AXES),
        time_s=12.0 * np.arange(poses, dtype=np.float64),
        block=block * 0,
        shown=shown,
        noise=spread.draw(rng),
        row={
            "tilt": made.tilt,
            "phase_rad": made.phase_rad,
            "contact": made.contact,
            "down_b": down_in_body(made.tilt),
            "mount": np.broadcast_to(made.mount, (poses, 6, 3, 3)).copy(),
            "hip_m": np.broadcast_to(made.hip_m, (poses, 6, 3)).copy(),
            "chassis_n": np.full(poses, made.total_n - legs.weight_n.sum()),
        },
        robot={
            "name": "hexapod",
            "mass_kg": round(made.total_n / GRAVITY_MPS2, 6),
            "legs": {
                name: {"position_m": place.tolist(), "rotation_rpy_rad": [0.0, 0.0, _nearest(m)]}
                for name, place, m in zip(legs.names, legs.hip_m, made.mount, strict=True)
            },
        },
        scale=np.ones(36),
        zero=np.zeros(36),
        facts={
            "noise": family,
            "sd_n": sd_n,
            "poses": poses,
            "legs": _plain(legs),
            "engine": abs(_nearest(made.mount[3])) > 1.0,
        },
        spread=spread,
    )


def drawn_poses(rng: Rng, poses: int) -> Poses:
    """Poses on uneven ground; mounted a little askew."""
    legs = draw_legs(rng, ALL_LEGS)
    total_n = float(np.round(rng.uniform(7.0, 11.0), 2)) * GRAVITY_MPS2
    tilt = rng.normal(0, rng.uniform(0.06, 0.12), (poses, 3)) * [1, 1, 4]
    phase = rng.uniform(-0.6, 0.6, (poses, 6))
    contact = np.ones((poses, 6))
    tripod = np.arange(poses) % 3 == 2
    left = np.array([True, False, True, False, True, False])
    side = rng.random(poses) < 0.5
    contact[tripod] = np.where(side[tripod, None], left, ~left)
    mount = small_turn(rng.normal(0, 0.015, (6, 3)))
    hip = legs.hip_m + rng.normal(0, 0.002, (6, 3))
    applied_b = _ground(rng, legs, hip, down_in_body(tilt), phase, contact, total_n)
    wrench = np.concatenate(
        [np.einsum("kji,pkj->pki", mount, applied_b[..., h]) for h in (slice(0, 3), slice(3, 6))],
        -1,
    )
    return Poses(legs, tilt, phase, contact, wrench, mount, hip, total_n)


def down_in_body(tilt: Array) -> Array:
    """Unit vector of gravity in body axes, for rotation vectors body to world, shape (p, 3)."""
    return np.asarray(np.einsum("pji,j->pi", small_turn(tilt), np.array([0.0, 0.0, -1.0])))


def _nearest(mount: Array) -> float:
    """0 or π: how the design mounts a transducer about z."""
    return float(np.pi) if mount[0, 0] < 0 else 0.0


def _plain(legs: Legs) -> dict[str, Any]:
    return {key: np.asarray(value).tolist() for key, value in vars(legs).items()}


def _ground(
    rng: Rng, legs: Legs, hip: Array, down_b: Array, phase: Array, contact: Array, total_n: float
) -> Array:
    """Wrench of leg and ground on each transducer in body axes, shape (p, 6, 6).

    Drawn at the feet (forces with friction, no torques), then corrected by the smallest change
    that carries the chassis with no moment about its centre.
    """
    poses = len(down_b)
    chassis_n = total_n - legs.weight_n.sum()
    foot = np.stack(
        [0.08 * np.sin(phase), np.full_like(phase, 0.09), -0.1 - 0.08 * np.cos(phase)], -1
    )
    foot[..., 1] *= np.sign(hip[:, 1])
    share = rng.uniform(0.3, 1.0, (poses, 6)) * contact
    share /= share.sum(axis=1, keepdims=True)
    force = (
        -share[..., None] * total_n * down_b[:, None]
        + 1.5 * rng.normal(size=(poses, 6, 3)) * contact[..., None]
    )
    arm = np.broadcast_to(legs.com_m[None, :, :, 0], (poses, 6, 3)) + np.einsum(
        "kij,pkj->pki", legs.com_m[:, :, 1:], np.stack([np.sin(phase), np.cos(phase)], -1)
    )
    weight = legs.weight_n[None, :, None] * down_b[:, None]
    own = np.concatenate([weight, np.cross(arm, weight)], -1)
    out = np.zeros((poses, 6, 6))
    for p in range(poses):
        on = np.flatnonzero(contact[p])
        # six equations: Σ f = −chassis weight, Σ hip × f + τ = 0, in the ground forces of the feet
        grid = np.zeros((6, 3 * on.size))
        for column, k in enumerate(on):
            part = slice(3 * column, 3 * column + 3)
            grid[:3, part] = np.eye(3)
            grid[3:, part] = _cross(hip[k] + foot[p, k])
        legs_sum = np.concatenate(
            [own[p, :, :3].sum(0), (own[p, :, 3:] + np.cross(hip, own[p, :, :3])).sum(0)]
        )
        wanted = -np.concatenate([chassis_n * down_b[p], np.zeros(3)]) - legs_sum
        first = force[p, on].ravel()
        ground = (first + np.linalg.pinv(grid) @ (wanted - grid @ first)).reshape(-1, 3)
        out[p] = own[p]
        out[p, on, :3] += ground
        out[p, on, 3:] += np.cross(foot[p, on], ground)
    return out


def _cross(v: Array) -> Array:
    return np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])


def error(world: World) -> Array:
    """Wrenches carried to the body centre + weight of the chassis, shape (p, 6).

    Offsets and mountings are at their true values: the calibrations move them.
    """
    row = world.row
    offset = np.array(world.facts["legs"]["offset"]).ravel()
    wrench = (world.shown - offset).reshape(-1, 6, 6)
    force = np.einsum("pkij,pkj->pki", row["mount"], wrench[..., :3])
    torque = np.einsum("pkij,pkj->pki", row["mount"], wrench[..., 3:]) + np.cross(
        row["hip_m"], force
    )
    return np.asarray(
        np.column_stack([force.sum(1) + row["chassis_n"][:, None] * row["down_b"], torque.sum(1)])
    )


def calibrations(world: World) -> Iterator[World]:
    """36 offsets, 18 mounting rotations, 18 mounting translations."""
    for i in range(36):
        shown = world.shown.copy()
        shown[:, i] += 0.01
        yield world.with_shown(shown)
    for k in range(6):
        for axis in np.eye(3):
            mount = world.row["mount"].copy()
            mount[:, k] = small_turn(1e-4 * axis) @ mount[:, k]
            yield world.with_row(mount=mount)
            hip = world.row["hip_m"].copy()
            hip[:, k] += 1e-4 * axis
            yield world.with_row(hip_m=hip)


def write(world: World, folder: Path, rng: Rng) -> None:
    """Poses, and hanging logs of the same robot from which to start."""
    wrench = (world.shown + world.noise).reshape(-1, 6, 6)
    poses = len(wrench)
    quat = Rotation.from_rotvec(world.row["tilt"]).as_quat()
    leg = np.tile(np.arange(6), poses)
    pose = np.repeat(np.arange(poses), 6)
    frame = pd.DataFrame(
        {
            "pose": [f"pose {p + 1}" for p in pose],
            "leg": np.array(ALL_LEGS)[leg],
            "phase_rad": np.round(world.row["phase_rad"].ravel(), 5),
            **{axis: np.round(wrench[pose, leg, i], 6) for i, axis in enumerate(AXES)},
            **{f"body_q{a}": quat[pose, i] for i, a in enumerate("xyzw")},
            "contact": world.row["contact"].ravel().astype(int),
        }
    )
    hung = hang.hanging(rng, legs_of(world.facts["legs"]), 5, sd_n=0.03)
    rows = {**hung.row, "time_s": hung.time_s, "wrench": hung.shown + hung.noise}
    logs = {
        "poses": write_log(frame, folder, "poses", rng),
        "hang": write_hang(folder, rng, rows, ALL_LEGS),
    }
    write_recipe(folder, world.robot, logs)


MAKER = Maker(draw, error, calibrations, write)
