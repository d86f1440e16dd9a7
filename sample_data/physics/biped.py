"""Physics-engine biped that stands and walks: measured-like truth that no model of ours made.

Run `python biped.py --out DIR` to write the four motions of `sample_data`.

Every row of a motion is the mean over the 10 ms centred on its stamp, so that the mean ground
force equals the change of momentum over the same 10 ms. The legs are position controlled; the
only disturbance is noise on the joint targets, so no force acts but gravity and the ground.
Frames: world x forward, y left, z up, ground at z = 0; a sole frame has its origin on the sole
under the ankle; SI units; g = 9.80665 m/s^2. A pad is a sphere of 5 mm whose lowest point lies in
the sole plane and sinks about 0.1 mm into the ground, so a flat foot in contact has z = -0.1 mm.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import mujoco  # type: ignore[import-untyped, unused-ignore]
import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
from scipy.signal import lfilter
from scipy.spatial.transform import Rotation
from walking import (
    GRAVITY_MPS2,
    HIP_OFFSET_M,
    PERIOD_S,
    STANCES,
    Array,
    Plan,
    Stance,
    ground_point,
    leg_angles,
    plan_stand,
    plan_walk,
    rate,
)

FEET = ("left", "right")
CELLS = ("fl", "fr", "rl", "rr")
CELL_X_M = (0.07, 0.07, -0.05, -0.05)
CELL_Y_M = (0.03, -0.03, 0.03, -0.03)
"""Pad centres in the sole frame, in the order of `CELLS`, the same for both feet."""
CELL_COLUMNS = tuple(f"{foot}_{cell}_n" for foot in FEET for cell in CELLS)

SAMPLE_S = 0.01
LANDING_S = 0.06
"""A sample this close to a touch-down is `landing`."""
CONTACT_N = 0.5
"""A foot that carries less is in the air."""
FALLEN_M = 0.2
"""A CoM this low is a fall."""
WARM_UP_S = 1.0
BALANCING_PASSES = 2
"""How often the CoM path is corrected for the angular momentum of the legs."""
COM_ITERATIONS, FIRST_COM_ITERATIONS = 2, 10
"""Iterations of inverse kinematics for the CoM; all samples but the first start from the last."""
JOINT_NOISE_SD_RAD = 0.0007
JOINT_NOISE_S = 0.15
"""Size and correlation time of the noise on the joint targets."""
WALK_SPEEDS_MPS = (0.02, 0.04, 0.1)
WALK_S = 60.0
STANCE_S = 4.0


class FallError(RuntimeError):
    """The robot fell."""


class Biped:
    """The robot, its joint controller and its sensors."""

    def __init__(self) -> None:
        """Load the model."""
        path = Path(__file__).with_name("biped.xml")
        self.model: Any = mujoco.MjModel.from_xml_path(str(path))
        self.data: Any = mujoco.MjData(self.model)
        self.mass_kg = float(self.model.body_subtreemass[0])
        self.step_s = float(self.model.opt.timestep)
        self.sensors = {
            self.model.sensor(i).name: slice(int(start), int(start + size))
            for i, (start, size) in enumerate(
                zip(self.model.sensor_adr, self.model.sensor_dim, strict=True)
            )
        }

    def motion(self, plan: Plan, duration_s: float, rng: np.random.Generator) -> pd.DataFrame:
        """Return the motion that comes of following a plan.

        Raises
        ------
        FallError : the CoM came below `FALLEN_M`
        """
        for _ in range(BALANCING_PASSES):
            momentum, _ = self.dynamics(plan, self.postures(plan))
            plan = plan.with_angular_momentum(rate(momentum), self.mass_kg)
        return motion_of(self.run(plan, duration_s, rng), self.sensors, self.step_s)

    def postures(self, plan: Plan) -> Array:
        """Return qpos (n, 19) with the torso upright and feet and CoM where the plan has them."""
        qpos = np.zeros((len(plan.com_m), self.model.nq))
        qpos[:, 3] = np.cos(plan.yaw_rad / 2.0)
        qpos[:, 6] = np.sin(plan.yaw_rad / 2.0)
        torso_from_com = np.zeros(3)
        for i, (com, feet, yaw) in enumerate(
            zip(plan.com_m, plan.feet_m, plan.yaw_rad, strict=True)
        ):
            left = HIP_OFFSET_M * np.array([-np.sin(yaw), np.cos(yaw), 0.0])
            for _ in range(COM_ITERATIONS if i else FIRST_COM_ITERATIONS):
                torso = com + torso_from_com
                qpos[i, :3] = torso
                qpos[i, 7:13] = leg_angles(torso + left, yaw, feet[0])
                qpos[i, 13:] = leg_angles(torso - left, yaw, feet[1])
                self.data.qpos[:] = qpos[i]
                mujoco.mj_kinematics(self.model, self.data)
                mujoco.mj_comPos(self.model, self.data)
                torso_from_com = torso - self.data.subtree_com[0]
        return qpos

    def dynamics(self, plan: Plan, qpos: Array) -> tuple[Array, Array]:
        """Return angular momentum about the CoM (n, 3) and joint torques (n, 12) of a motion.

        The torques are those of inverse dynamics with the ground force m (c'' + g) acting at the
        ZMP, shared by the feet.
        """
        model, data = self.model, self.data
        qvel = np.zeros((len(qpos), model.nv))
        qvel[:, :3] = rate(qpos[:, :3])
        qvel[:, 5] = rate(plan.yaw_rad)
        qvel[:, 6:] = rate(qpos[:, 7:])
        qacc = rate(qvel)
        force = self.mass_kg * (plan.com_acc_mps2 + np.array([0.0, 0.0, GRAVITY_MPS2]))
        share = np.column_stack([plan.left_share, 1.0 - plan.left_share])
        feet = [int(model.body(f"{foot}_foot").id) for foot in FEET]
        momentum, torque = np.empty((len(qpos), 3)), np.empty((len(qpos), model.nv))
        jacobian = np.empty((3, model.nv))
        for i in range(len(qpos)):
            data.qpos[:], data.qvel[:], data.qacc[:] = qpos[i], qvel[i], qacc[i]
            mujoco.mj_kinematics(model, data)
            mujoco.mj_comPos(model, data)
            mujoco.mj_comVel(model, data)
            mujoco.mj_subtreeVel(model, data)
            momentum[i] = data.subtree_angmom[0]
            mujoco.mj_rne(model, data, 1, torque[i])
            centres = [ground_point(foot) for foot in plan.feet_m[i]]
            off_centre = plan.zmp_m[i] - share[i] @ centres
            for body, centre, part in zip(feet, centres, share[i], strict=True):
                point = np.array([*(centre + off_centre), 0.0])
                mujoco.mj_jac(model, data, jacobian, None, point, body)
                torque[i] -= part * (jacobian.T @ force[i])
        return momentum, (torque + model.dof_armature * qacc)[:, 6:]

    def targets(self, plan: Plan, qpos: Array) -> Array:
        """Return the joint targets (n, 12) whose servo torques make the robot follow `qpos`."""
        gain = self.model.actuator_gainprm[:, 0]
        damping = self.model.dof_damping[6:] - self.model.actuator_biasprm[:, 2]
        _, torque = self.dynamics(plan, qpos)
        joints = qpos[:, 7:]
        return np.asarray(joints + (torque + damping * rate(joints)) / gain)

    def run(self, plan: Plan, duration_s: float, rng: np.random.Generator) -> Array:
        """Return all sensors at every physics step, (steps + 1, sensors), after a warm-up.

        Raises
        ------
        FallError : the CoM came below `FALLEN_M`
        """
        model, data = self.model, self.data
        per_period = round(PERIOD_S / self.step_s)
        warm_up, n = round(WARM_UP_S / PERIOD_S), round(duration_s / PERIOD_S)
        qpos = self.postures(plan)
        targets = self.targets(plan, qpos)
        targets = np.concatenate([np.tile(targets[0], (warm_up, 1)), targets[: n + 1]])
        targets += _joint_noise(rng, targets.shape)
        mujoco.mj_resetData(model, data)
        data.qpos[:] = qpos[0]
        record = np.empty(((warm_up + n) * per_period + 1, model.nsensordata))
        fractions = np.arange(1, per_period + 1)[:, None] / per_period
        for k in range(warm_up + n):
            for j, control in enumerate(targets[k] + fractions * (targets[k + 1] - targets[k])):
                data.ctrl[:] = control
                mujoco.mj_step(model, data)
                record[k * per_period + j] = data.sensordata
            if data.subtree_com[0, 2] < FALLEN_M:
                raise FallError(f"fell at {k * PERIOD_S - WARM_UP_S:.2f} s")
        mujoco.mj_forward(model, data)
        record[-1] = data.sensordata
        return record[warm_up * per_period :]


def _joint_noise(rng: np.random.Generator, shape: tuple[int, int]) -> Array:
    """Return smooth noise (rad): white noise through two equal low-passes in time."""
    decay = np.exp(-PERIOD_S / JOINT_NOISE_S)
    a = [1.0, -2.0 * decay, decay**2]
    gain = np.sqrt((1.0 + decay**2) / (1.0 - decay**2) ** 3)
    white = rng.normal(0.0, JOINT_NOISE_SD_RAD / gain, shape)
    return np.asarray(lfilter([1.0], a, white, axis=0))


def motion_of(record: Array, sensors: dict[str, slice], step_s: float) -> pd.DataFrame:
    """Return sensors at every physics step as 10 ms means, one row per window.

    Forces act from one step to the next, so their plain mean over a window belongs to the change
    of momentum over it ([NAO], eqs. 6 and 7); states are averaged by the trapezoidal rule.
    Accelerations and the rate of angular momentum are differences of velocity and momentum.
    """
    per_row = round(SAMPLE_S / step_s)
    n = (len(record) - 1) // per_row
    record = record[: n * per_row + 1]
    forces = record[:-1, sensors["left_fl"].start : sensors["right_rr"].stop]
    edges = record[::per_row]
    # the trapezoidal rule over a window: all its steps, the first and the last by half
    sums = record[:-1].reshape(n, per_row, -1).sum(axis=1)
    means = (sums + (edges[1:] - edges[:-1]) / 2.0) / per_row
    rates = np.diff(edges, axis=0) / SAMPLE_S

    columns: dict[str, Array] = {"time_s": (np.arange(n, dtype=float) + 0.5) * SAMPLE_S}
    pads = forces.reshape(n, per_row, -1).mean(axis=1)
    columns.update(zip(CELL_COLUMNS, pads.T, strict=True))
    columns.update(_axes("com_{}_m", means[:, sensors["com"]]))
    columns.update(_axes("com_acc_{}_mps2", rates[:, sensors["com_vel"]]))
    columns.update(_axes("angmom_rate_{}_nm", rates[:, sensors["angmom"]][:, :2]))
    for foot in FEET:
        ahead = record[:, sensors[f"{foot}_foot_x_axis"]]
        yaw = np.unwrap(np.arctan2(ahead[:, 1], ahead[:, 0]))
        yaw_sum = yaw[:-1].reshape(n, per_row).sum(axis=1)
        columns.update(_axes(f"{foot}_foot_{{}}_m", means[:, sensors[f"{foot}_foot"]]))
        columns[f"{foot}_foot_yaw_rad"] = (yaw_sum + np.diff(yaw[::per_row]) / 2.0) / per_row
    force_w = rates[:, sensors["imu_vel"]] + np.array([0.0, 0.0, GRAVITY_MPS2])
    torso = Rotation.from_quat(means[:, sensors["imu_quat"]], scalar_first=True)
    columns.update(_axes("imu_acc_{}_mps2", torso.inv().apply(force_w)))
    columns.update(_axes("imu_gyro_{}_radps", means[:, sensors["imu_gyro"]]))
    columns["landing"] = _landing(forces, step_s, columns["time_s"])
    return pd.DataFrame(columns)


def _axes(pattern: str, values: Array) -> Iterator[tuple[str, Array]]:
    """Yield one named column per axis."""
    return ((pattern.format(axis), column) for axis, column in zip("xyz", values.T, strict=False))


def _landing(forces: Array, step_s: float, time_s: Array) -> Array:
    """Return where a sample lies within `LANDING_S` of a touch-down of either foot."""
    near = np.zeros(len(time_s), dtype=bool)
    for foot in range(2):
        down = forces[:, 4 * foot : 4 * foot + 4].sum(axis=1) > CONTACT_N
        for touch_s in (np.flatnonzero(down[1:] & ~down[:-1]) + 1) * step_s:
            near |= np.abs(time_s - touch_s) <= LANDING_S
    return near


@dataclass(frozen=True)
class Balance:
    """RMS of what should vanish by Newton and Euler, in single support for the CoP.

    Parameters
    ----------
    force_pct, force_landing_pct : sum of pads against m (c_z'' + g), percent of body weight,
        landing excluded and included
    cop_m, cop_landing_m : CoP from the pads against [NAO] eqs. (10) and (11), landing excluded
        and included; NaN where there is no single support
    """

    force_pct: float
    force_landing_pct: float
    cop_m: float
    cop_landing_m: float


def pads_cop(motion: pd.DataFrame) -> Array:
    """Return the CoP (n, 2) in m from pad forces and foot poses; [NAO], eq. (8)."""
    moment, total = np.zeros((len(motion), 2)), np.zeros(len(motion))
    for foot in FEET:
        yaw = motion[f"{foot}_foot_yaw_rad"].to_numpy()
        origin = motion[[f"{foot}_foot_x_m", f"{foot}_foot_y_m"]].to_numpy()
        for cell, x, y in zip(CELLS, CELL_X_M, CELL_Y_M, strict=True):
            force = motion[f"{foot}_{cell}_n"].to_numpy()
            arm = np.column_stack(
                [np.cos(yaw) * x - np.sin(yaw) * y, np.sin(yaw) * x + np.cos(yaw) * y]
            )
            moment += force[:, None] * (origin + arm)
            total += force
    return np.asarray(moment / total[:, None])


def dynamic_cop(motion: pd.DataFrame, mass_kg: float) -> Array:
    """Return the CoP (n, 2) in m from the motion of the body; [NAO], eqs. (10) and (11)."""
    com, acc = (
        motion[[pattern.format(axis) for axis in "xyz"]].to_numpy(dtype=float)
        for pattern in ("com_{}_m", "com_acc_{}_mps2")
    )
    rate_x, rate_y = (motion[f"angmom_rate_{axis}_nm"].to_numpy(dtype=float) for axis in "xy")
    fz = mass_kg * (acc[:, 2] + GRAVITY_MPS2)
    x = com[:, 0] - (com[:, 2] * mass_kg * acc[:, 0] + rate_y) / fz
    y = com[:, 1] - (com[:, 2] * mass_kg * acc[:, 1] - rate_x) / fz
    return np.column_stack([x, y])


def check_balance(motion: pd.DataFrame, mass_kg: float) -> Balance:
    """Return how well the pads agree with Newton and Euler."""
    loads = [motion[[f"{foot}_{cell}_n" for cell in CELLS]].sum(axis=1) for foot in FEET]
    single = ((loads[0] < CONTACT_N) | (loads[1] < CONTACT_N)).to_numpy()
    quiet = ~motion["landing"].to_numpy(dtype=bool)
    fz = mass_kg * (motion["com_acc_z_mps2"] + GRAVITY_MPS2)
    force_pct = ((loads[0] + loads[1] - fz) / (mass_kg * GRAVITY_MPS2) * 100.0).to_numpy()
    cop_m = np.linalg.norm(pads_cop(motion) - dynamic_cop(motion, mass_kg), axis=1)
    return Balance(
        _rms(force_pct[quiet]), _rms(force_pct), _rms(cop_m[single & quiet]), _rms(cop_m[single])
    )


def _rms(x: Array) -> float:
    return float(np.sqrt(np.mean(np.square(x)))) if len(x) else float("nan")


def walk(speed_mps: float, duration_s: float, seed: int, turn_radps: float = 0.0) -> pd.DataFrame:
    """Return the motion of a walk that starts with 2 s of standing.

    Raises
    ------
    FallError : the robot fell
    """
    rng = np.random.default_rng(seed)
    plan = plan_walk(speed_mps, duration_s, rng, turn_radps)
    return Biped().motion(plan, duration_s, rng)


def stand(stances: Sequence[Stance], seconds_each: float, seed: int) -> pd.DataFrame:
    """Return quiet stances of `seconds_each` and the transitions between them.

    `attrs["stances"]` of the result lists the quiet stretches as [name, start_s, end_s].

    Raises
    ------
    FallError : the robot fell
    """
    plan = plan_stand(stances, seconds_each)
    motion = Biped().motion(plan, plan.duration_s, np.random.default_rng(seed))
    motion.attrs["stances"] = [list(stance) for stance in plan.stances]
    return motion


def write_motion(motion: pd.DataFrame, path: Path) -> None:
    """Write a motion as Parquet: float32, time float64."""
    values = [name for name in motion.columns if name not in ("time_s", "landing")]
    table = pa.Table.from_pandas(
        motion.astype(dict.fromkeys(values, "float32")), preserve_index=False
    )
    pq.write_table(
        table,
        path,
        compression="zstd",
        compression_level=19,
        use_dictionary=False,
        use_byte_stream_split=["time_s", *values],
    )


def main(arguments: Sequence[str] | None = None) -> None:
    """Write the motions and print how well they balance."""
    parser = argparse.ArgumentParser(description=main.__doc__)
    parser.add_argument("--out", type=Path, required=True, help="folder to write to")
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args(arguments)
    options.out.mkdir(parents=True, exist_ok=True)
    mass_kg = Biped().mass_kg
    print(f"mass {mass_kg:.3f} kg; RMS, in brackets with landing")
    makers = {f"walk_{v}": partial(walk, v, WALK_S, options.seed) for v in WALK_SPEEDS_MPS}
    makers["stand"] = partial(stand, STANCES, STANCE_S, options.seed)
    for name, make in makers.items():
        start = time.perf_counter()
        motion = make()
        b = check_balance(motion, mass_kg)
        path = options.out / f"motion_{name}.parquet"
        write_motion(motion, path)
        print(
            f"{name:10s} {len(motion) * SAMPLE_S:6.1f} s"
            f"  force {b.force_pct:.3f} ({b.force_landing_pct:.3f}) % of body weight"
            f"  CoP {b.cop_m * 1e3:.3f} ({b.cop_landing_m * 1e3:.3f}) mm"
            f"  {path.stat().st_size / 1e6:.2f} MB  {time.perf_counter() - start:.1f} s"
        )


if __name__ == "__main__":
    main()
