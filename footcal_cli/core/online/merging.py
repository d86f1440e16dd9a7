"""Sensors and body, each on its own clock, merged to the log of a walk or a stand."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from footcal_cli.core.centroidal import points_in_world
from footcal_cli.core.contact import (
    Reason,
    airborne,
    airborne_now,
    carried_over,
    contact_now,
    detect_contact,
    flicker,
    judge,
)
from footcal_cli.core.log import Log
from footcal_cli.core.online.belief import Belief
from footcal_cli.core.online.streams import BodyStream, Merged, MergeRule, SensorStream
from footcal_cli.core.parameters import BoolArray, FloatArray, IntArray
from footcal_cli.core.signals import (
    Clock,
    acceleration_of,
    clock_of,
    interpolate_stream,
    low_pass_stretches,
    slopes_of,
)
from footcal_cli.errors import DataError

_LONGEST_BODY_GAP_PERIODS = 5.0
_CELL_GAP_PERIODS = 3.5


def merge_cells(
    sensors: SensorStream,
    body: BodyStream,
    belief: Belief,
    cells_foot_m: tuple[FloatArray, ...],
    mass_kg: float,
    gravity_mps2: float,
    *,
    experiment: str = "walk",
    rule: MergeRule | None = None,
) -> Merged:
    """Merge load cells and body stream to the log of a walk or a stand.

    Parameters
    ----------
    sensors
        Channels foot by foot, in the order of `cells_foot_m`.
    belief
        Calibration by which contact is detected.
    cells_foot_m
        Cell positions in each foot's frame, shape (cells, 2) each.
    """
    rule = rule or MergeRule()
    both = _Both.of(sensors, body, rule)
    good, seen, rate, values = both.good, both.seen, both.rate_hz, both.body
    filtered = low_pass_stretches(both.readings, good, rate, rule.cutoff_hz, causal=rule.causal)
    forces = belief.forces(filtered)
    edges = np.cumsum([0, *(len(cells) for cells in cells_foot_m)])
    per_foot = np.stack([forces[:, a:b].sum(axis=1) for a, b in pairwise(edges)], axis=1)
    weight = mass_kg * gravity_mps2
    if rule.causal:
        contact = contact_now(per_foot, weight, rate, rule.contact)
        hanging = airborne_now(per_foot, weight, rule.contact)
    else:
        contact = detect_contact(per_foot, weight, rate, rule.contact)
        hanging = airborne(contact)
    positions = [
        points_in_world(values["feet_m"][:, f, :2], values["feet_yaw_rad"][:, f], cells)
        for f, cells in enumerate(cells_foot_m)
    ]
    acceleration = np.linalg.norm(values["com_acc_mps2"], axis=1)
    doubtful = seen & (acceleration > rule.largest_acc_mps2)
    total = np.where(good, per_foot.sum(axis=1), 0.0)
    reasons = {
        Reason.DROPOUT: ~(good & seen),
        Reason.NO_CONTACT: good & (total < rule.min_force_n),
        Reason.TRANSITION: np.isnan(contact).all(axis=1) & good,
        Reason.LOW_IMU_CONFIDENCE: doubtful,
    }
    known = both.motion(len(cells_foot_m), mass_kg, gravity_mps2, rule.min_force_n) | {
        "com_acc_mps2": np.where(doubtful[:, None], np.nan, values["com_acc_mps2"]),
        "cell_pos_m": np.concatenate(positions, axis=1),
        "contact": contact,
        "airborne": hanging,
    }
    if not rule.causal:
        known["carried_over"] = carried_over(
            both.readings, good, contact, _columns_between(edges), rate, rule.cutoff_hz
        )
    return both.merged(experiment, filtered, good, known, reasons)


def merge_six_axis(
    sensors: SensorStream,
    body: BodyStream,
    sensor_in_foot: tuple[tuple[FloatArray, FloatArray], ...],
    weight_below_n: FloatArray,
    com_below_m: FloatArray,
    mass_kg: float,
    gravity_mps2: float,
    *,
    experiment: str = "walk",
    rule: MergeRule | None = None,
) -> Merged:
    """Merge six-axis feet and body stream to the log of a walk or a stand.

    Parameters
    ----------
    sensor_in_foot
        Position (3,) and rotation (3, 3) of each transducer in its foot's frame.
    weight_below_n
        Weight below each transducer and its sd, shape (feet, 2).
    com_below_m
        Its CoM in the transducer's frame, shape (feet, 3).
    """
    rule = rule or MergeRule()
    if body.feet_rot is None:
        raise DataError(
            "six-axis feet need the orientation of the feet", column="left_foot_qw …",
            remedy="log the feet's quaternions or their yaw",
        )  # fmt: skip
    hanging = np.stack(
        [
            place + turned @ com
            for (place, turned), com in zip(sensor_in_foot, com_below_m, strict=True)
        ]
    )
    both = _Both.of(sensors, body, rule, hanging)
    good, rate = both.good, both.rate_hz
    rot, pos = _transducers_in_world(both.body, sensor_in_foot)
    n, feet = rot.shape[:2]

    def vertical_of(wrench: FloatArray) -> FloatArray:
        force = wrench.reshape(n, feet, 6)[..., :3]
        return np.asarray(np.einsum("nkj,nkj->nk", rot[:, :, 2, :], force) + weight_below_n[:, 0])

    broken = np.zeros(n, dtype=bool)
    if not rule.causal:
        spikes = flicker(vertical_of(both.readings), mass_kg * gravity_mps2, rate, rule.contact)
        broken = spikes.any(axis=1) & good
    sound = good & ~broken
    filtered = low_pass_stretches(both.readings, sound, rate, rule.cutoff_hz, causal=rule.causal)
    vertical = vertical_of(np.where(sound[:, None], filtered, np.nan))
    contact = detect_contact(vertical, mass_kg * gravity_mps2, rate, rule.contact)
    reasons = {
        Reason.DROPOUT: ~(good & both.seen),
        Reason.OUTLIER: broken,
        Reason.TRANSITION: np.isnan(contact).all(axis=1) & good,
    }
    known = both.motion(feet, mass_kg, gravity_mps2, rule.min_force_n) | {
        "contact": contact,
        "foot_rot_wt": rot,
        "foot_pos_m": pos,
        "foot_weight_n": np.tile(weight_below_n[:, 0], (n, 1)),
        "foot_weight_sd_n": np.tile(weight_below_n[:, 1], (n, 1)),
        "foot_com_m": np.tile(com_below_m, (n, 1, 1)),
    }
    if not rule.causal:
        columns = _columns_between(np.arange(0, 6 * feet + 1, 6))
        known["carried_over"] = carried_over(
            both.readings, sound, contact, columns, rate, rule.cutoff_hz
        )
    return both.merged(experiment, filtered, sound, known, reasons)


def _columns_between(edges: IntArray) -> list[IntArray]:
    """Columns of each foot, from the first of each and one past the last."""
    return [np.arange(a, b) for a, b in pairwise(edges)]


def _transducers_in_world(
    body: Mapping[str, FloatArray], sensor_in_foot: tuple[tuple[FloatArray, FloatArray], ...]
) -> tuple[FloatArray, FloatArray]:
    """Rotation (n, feet, 3, 3) and position (n, feet, 3) of each foot's transducer."""
    feet_rot = _orthonormal(body["feet_rot"])
    rot = [feet_rot[:, k] @ turned for k, (_, turned) in enumerate(sensor_in_foot)]
    pos = [
        body["feet_m"][:, k] + feet_rot[:, k] @ place for k, (place, _) in enumerate(sensor_in_foot)
    ]
    return np.stack(rot, axis=1), np.stack(pos, axis=1)


@dataclass(frozen=True)
class _Both:
    """Sensors and body at the sensors' stamps that are kept.

    Parameters
    ----------
    readings
        As they were logged, shape (n, channels).
    good, seen
        Whether the readings, and the body's stream, are whole there, shape (n,).
    body
        Values of the body's stream by name, n rows each.
    """

    sensors: SensorStream
    at: IntArray
    readings: FloatArray
    good: BoolArray
    seen: BoolArray
    body: Mapping[str, FloatArray]
    clock: Clock
    body_clock: Clock

    @classmethod
    def of(
        cls,
        sensors: SensorStream,
        body: BodyStream,
        rule: MergeRule,
        moved_m: FloatArray | None = None,
    ) -> _Both:
        """Both streams at the sensors' stamps; `moved_m` as in `_body_on`."""
        at, clock, whole = _sensor_rows(sensors)
        readings = sensors.readings[at]
        values, seen, body_clock = _body_on(body, sensors.time_s[at], rule, moved_m)
        good = whole & np.isfinite(readings).all(axis=1)
        return cls(sensors, at, readings, good, seen, values, clock, body_clock)

    @property
    def rate_hz(self) -> float:
        """Of the sensors."""
        return 1.0 / self.clock.period_s

    def motion(
        self, feet: int, mass_kg: float, gravity_mps2: float, min_force_n: float
    ) -> dict[str, FloatArray]:
        """What is known of any robot's motion (`Log.known`)."""
        n, values = self.at.size, self.body
        return {
            "com_m": values["com_m"],
            "com_acc_mps2": values["com_acc_mps2"],
            "angmom_rate_nm": values["angmom_rate_nm"],
            "mass_kg": np.full(n, mass_kg),
            "gravity_mps2": np.full(n, gravity_mps2),
            "min_force_n": np.full(n, min_force_n),
            "foot_yaw_rad": values["feet_yaw_rad"],
            "foot_acc_mps2": values["feet_acc_mps2"].reshape(n, feet, -1),
        }

    def merged(
        self,
        experiment: str,
        filtered: FloatArray,
        sound: BoolArray,
        known: dict[str, FloatArray],
        reasons: Mapping[Reason, BoolArray],
    ) -> Merged:
        """The log of filtered readings, those that are not sound left out."""
        n = self.at.size
        usable = np.where((sound & self.seen)[:, None], filtered, np.nan)
        block = np.zeros(n, dtype=np.int64)
        log = Log(
            experiment, self.sensors.channels, self.sensors.time_s[self.at], usable, known, block
        )
        return Merged(
            log, self.readings, judge(reasons, n), self.clock, self.body_clock, self.rate_hz,
            self.body.get("imu_acc_mps2"), self.body.get("imu_gyro_radps"),
        )  # fmt: skip


def _sensor_rows(sensors: SensorStream) -> tuple[IntArray, Clock, BoolArray]:
    """Rows kept, the clock, and which rows are not beside a gap."""
    clock = clock_of(sensors.time_s)
    if clock.keep.size < 4:
        raise DataError(
            f"only {clock.keep.size} of {sensors.time_s.size} samples have increasing stamps",
            remedy="check the stamps (footcal check), or record a longer log",
        )
    time_s = sensors.time_s[clock.keep]
    whole = np.ones(time_s.size, dtype=bool)
    broken = np.flatnonzero(np.diff(time_s) > _CELL_GAP_PERIODS * clock.period_s)
    # the row after a gap starts a new stretch: leave it out so that filters do not reach across
    whole[broken + 1] = False
    return clock.keep, clock, whole


def _body_on(
    body: BodyStream, at_s: FloatArray, rule: MergeRule, moved_m: FloatArray | None = None
) -> tuple[dict[str, FloatArray], BoolArray, Clock]:
    """The body stream at the sensors' stamps, delay compensated, accelerations filtered.

    The accelerations of the feet are those of points in the feet's frames, `moved_m` (feet, 3): a
    foot that pitches accelerates its own CoM.
    """
    clock = clock_of(body.time_s)
    keep = clock.keep
    if keep.size < 4:
        raise DataError(
            f"{keep.size} samples of the body stream with increasing stamps are too few",
            column="time_s", remedy="check its stamps (footcal check)",
        )  # fmt: skip
    time_s = body.time_s[keep]
    parts: dict[str, FloatArray] = {
        "com_m": body.com_m[keep],
        "com_acc_mps2": body.com_acc_mps2[keep],
        "angmom_rate_nm": body.angmom_rate_nm[keep],
        "feet_m": body.feet_m[keep],
        "feet_yaw_rad": np.unwrap(body.feet_yaw_rad[keep], axis=0),
    }
    if not np.isfinite(parts["com_acc_mps2"]).any():
        speed = body.com_vel_mps
        parts["com_acc_mps2"] = (
            acceleration_of(parts["com_m"], time_s) if speed is None
            else slopes_of(speed[keep], time_s)
        )  # fmt: skip
    if body.angmom_nms is not None:
        parts["angmom_rate_nm"] = slopes_of(body.angmom_nms[keep], time_s)
    for name, optional in (
        ("feet_rot", body.feet_rot),
        ("imu_acc_mps2", body.imu_acc_mps2),
        ("imu_gyro_radps", body.imu_gyro_radps),
    ):
        if optional is not None:
            parts[name] = optional[keep]
    at_m = parts["feet_m"]
    if moved_m is not None and "feet_rot" in parts:
        at_m = at_m + np.einsum("nkij,kj->nki", parts["feet_rot"], moved_m)
    feet_acc = acceleration_of(at_m, time_s)
    parts["feet_acc_mps2"] = feet_acc.reshape(keep.size, -1)
    smoothed = ["com_acc_mps2", "angmom_rate_nm", "feet_acc_mps2"]
    if rule.causal:
        # what lags must lag together: the CoP of late forces lies where the CoM was
        smoothed += ["com_m", "feet_m", "feet_yaw_rad"]
    for name in smoothed:
        flat = np.isfinite(parts[name].reshape(keep.size, -1))
        finite = np.asarray(flat.all(axis=1), dtype=bool)
        parts[name] = low_pass_stretches(
            parts[name], finite, 1.0 / clock.period_s, rule.cutoff_hz, causal=rule.causal
        )
    # what a stream never has (the CoM of a robot that says nothing) spoils no sample
    required = [n for n in parts if not n.startswith("imu") and np.isfinite(parts[n]).any()]
    stacked = np.concatenate([parts[n].reshape(keep.size, -1) for n in parts], axis=1)
    longest = _LONGEST_BODY_GAP_PERIODS * clock.period_s
    merged, _ = interpolate_stream(time_s - rule.delay_s, stacked, at_s, max_gap_s=longest)
    _, covered = interpolate_stream(
        time_s - rule.delay_s, np.zeros((keep.size, 1)), at_s, max_gap_s=longest
    )
    values, start = {}, 0
    for name, part in parts.items():
        width = int(np.prod(part.shape[1:]))
        values[name] = merged[:, start : start + width].reshape(at_s.size, *part.shape[1:])
        start += width
    complete = np.stack(
        [np.isfinite(values[n]).reshape(at_s.size, -1).all(axis=1) for n in required], axis=1
    ).all(axis=1)
    return values, np.asarray(covered & complete), clock


def _orthonormal(rot: FloatArray) -> FloatArray:
    """The rotations nearest to interpolated ones; NaN stays."""
    flat = rot.reshape(-1, 3, 3)
    finite = np.isfinite(flat).all(axis=(1, 2))
    out = np.full(flat.shape, np.nan)
    left, _, right = np.linalg.svd(flat[finite])
    out[finite] = left @ right
    return out.reshape(rot.shape)
