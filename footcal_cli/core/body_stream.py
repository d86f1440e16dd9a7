"""What a robot says of its own motion, against what bodies, feet and clocks can do.

Units and conventions that are not the canonical ones change a stream by factors or turn it over;
each check looks for such a change and names the likely cause. None of them changes a number.
"""

from __future__ import annotations

import numpy as np

from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.quality import Finding
from footcal_cli.core.saturation import find_cut_impacts
from footcal_cli.core.spatial import rotation_of_quaternion

SLOWEST_S = 0.5
"""Longest interval of a stream of standing or walking."""
FASTEST_S = 2e-5
"""Shortest interval of any stream of forces or bodies."""
MEAN_ACC_MPS2 = 2.0
"""A body that accelerates so on average leaves the laboratory within seconds."""
MOTION_WINDOW_S = 1.0
"""Length of the bump over which positions and accelerations are compared."""
AGREE = 0.8
"""Correlation of accelerations with the motion from which their ratio means anything."""
FASTEST_TURN_RADPS = 20.0
"""No foot turns faster about the vertical."""
MOST_TURNS_RAD = 4.0 * np.pi
"""Headings beyond are degrees, or a robot that turned more than twice."""
ACROSS_RAD, IN_DEGREES = 0.8, 0.3
"""Steps turn the line from foot to foot by half a radian; a heading that lies further off, and
as degrees within this share of it, is one in degrees."""
_ACC_UNITS = {1.0 / 9.80665: "in g", 1e3: "in mm/s²", 1e2: "in cm/s²", -1.0: "of reversed sign"}
_STAMP_UNITS = (
    (1e3, "ms", "milliseconds"), (1e6, "us", "microseconds"), (1e9, "ns", "nanoseconds"),
)  # fmt: skip
_FEWEST, _FEWEST_SAMPLES = 20, 100
_UNEXPLAINED, _EXPLAINED = 0.6, 0.85
_STRAIGHT_S = 8.0
"""Shares of the change of the forces that motion explains at wrong and at right stamps."""


def _alarm(code: str, where: str, sentence: str, remedy: str) -> Finding:
    return Finding(code, "alarm", where, sentence, remedy)


def check_stamp_unit(
    time_s: FloatArray, where: str, *, slowest_s: float = SLOWEST_S
) -> list[Finding]:
    """Find stamps that cannot be seconds, by the usual interval, in whatever order they stand.

    Parameters
    ----------
    time_s
        Shape (n,).
    slowest_s
        Longest interval that such a recording may have.
    """
    steps = np.diff(np.sort(time_s[np.isfinite(time_s)]))
    steps = steps[steps > 0]
    if steps.size < _FEWEST:
        return []
    usual = float(np.median(steps))
    if FASTEST_S < usual <= slowest_s:
        return []
    cause, short = "they are no seconds", "ms"
    if usual > slowest_s:
        for factor, unit, name in _STAMP_UNITS:
            if FASTEST_S * 10 < usual / factor <= slowest_s:
                cause, short = f"the stamps look like {name}", unit
                break
    return [
        _alarm(
            "stamps_not_seconds", where,
            f"the usual interval between samples is {usual:.4g} s: {cause}",
            f'give the unit in [columns], time_s = {{ column = "…", unit = "{short}" }}',
        )
    ]  # fmt: skip


def check_overlap(
    first_s: FloatArray, second_s: FloatArray, first: str, second: str
) -> list[Finding]:
    """Find two streams of one recording that were not recorded at the same time."""
    spans = [(float(np.nanmin(t)), float(np.nanmax(t))) for t in (first_s, second_s) if t.size]
    if len(spans) < 2:
        return []
    common = min(spans[0][1], spans[1][1]) - max(spans[0][0], spans[1][0])
    shorter = min(end - start for start, end in spans)
    if common > 0.1 * shorter:
        return []
    apart = -common
    far = f"{apart / 86400:.4g} days" if apart > 86400 else f"{max(apart, 0.0):.4g} s"
    return [
        _alarm(
            "streams_apart", f"{first}, {second}",
            f"the streams share {max(common, 0.0):.3g} s of {shorter:.3g} s; between them lie {far}"
            if common > 0
            else f"the streams share no moment: between them lie {far}",
            "give logs of the same recording, with stamps of one clock",
        )
    ]  # fmt: skip


def check_rates(
    time_s: FloatArray, forces_n: FloatArray, body_s: FloatArray, motion: FloatArray, where: str
) -> list[Finding]:
    """Find two streams of which one counts its seconds at twice the rate of the other.

    How the forces change is explained by the body's motion, at the stamps as they are or with the
    sensors' stamps stretched about their first. Rows of one table have one clock.

    Parameters
    ----------
    time_s, forces_n
        Stamps and forces of the sensors, shapes (n,) and (n, c).
    body_s, motion
        Stamps, and CoM and acceleration, shapes (m,) and (m, 6).
    """
    if np.array_equal(time_s, body_s, equal_nan=True):
        return []
    good = np.isfinite(forces_n).all(axis=1) & np.isfinite(time_s)
    sound = np.isfinite(motion).all(axis=1) & np.isfinite(body_s)
    if good.sum() < _FEWEST_SAMPLES or sound.sum() < _FEWEST_SAMPLES:
        return []
    time, force = time_s[good], forces_n[good]
    centred = force - force.mean(axis=0)
    moving = centred @ np.linalg.svd(centred, full_matrices=False)[2][0]
    there, known = body_s[sound], motion[sound]

    def explained(stretch: float) -> float:
        at = time[0] + stretch * (time - time[0])
        inside = (at >= there[0]) & (at <= there[-1])
        if inside.sum() < _FEWEST_SAMPLES:
            return 0.0
        said = np.stack([np.interp(at[inside], there, column) for column in known.T], axis=1)
        # a robot that turns loads its feet by another axis of the world after a while
        parts = max(int(np.ptp(at[inside]) / _STRAIGHT_S), 1)
        squares = np.zeros(2)
        for own, felt in zip(
            np.array_split(said, parts), np.array_split(moving[inside], parts), strict=True
        ):
            own, felt = own - own.mean(axis=0), felt - felt.mean()
            left = felt - own @ np.linalg.lstsq(own, felt, rcond=1e-8)[0]
            squares += float(left @ left), float(felt @ felt)
        return 1.0 - float(squares[0] / max(squares[1], 1e-300))

    as_written = explained(1.0)
    best = max((0.5, 2.0), key=explained)
    if as_written > _UNEXPLAINED or explained(best) < _EXPLAINED:
        return []
    return [
        _alarm(
            "rates_differ", where,
            f"the forces follow the body's motion ({explained(best):.0%} of their change) only if "
            f"the sensors' seconds last {best:g} s; as they are written, {as_written:.0%}",
            "correct the rate or the unit of the stamps of one stream",
        )
    ]  # fmt: skip


def check_acceleration(
    time_s: FloatArray, com_m: FloatArray, com_acc_mps2: FloatArray, gravity_mps2: float, where: str
) -> list[Finding]:
    """Find CoM accelerations that hold gravity, or are not those of the CoM's own motion.

    With a smooth bump φ of some tenths of a second, ``∫ φ̈ p dt = ∫ φ p̈ dt`` for every motion, so
    that no position is differentiated.

    Parameters
    ----------
    time_s, com_m, com_acc_mps2
        Shapes (n,), (n, 3) and (n, 3).
    """
    good = np.isfinite(com_acc_mps2).all(axis=1) & np.isfinite(time_s)
    if good.sum() < _FEWEST:
        return []
    ratio, agreement = _motion_ratio(time_s, com_m, com_acc_mps2)
    if abs(agreement) < AGREE or 0.5 < ratio < 2.0:
        return _mean_acceleration(com_acc_mps2[good], gravity_mps2, where)
    unit = min(_ACC_UNITS, key=lambda r: abs(np.log(abs(ratio / r))) + 9.0 * (r * ratio < 0))
    known = unit * ratio > 0 and 0.7 < ratio / unit < 1.4
    cause = f"it looks {_ACC_UNITS[unit]}" if known else "its unit or that of the CoM is wrong"
    return [
        _alarm(
            "acceleration_not_of_com", where,
            f"the acceleration is {ratio:.3g} times that of the CoM's own motion (correlation "
            f"{agreement:.2f}): {cause}",
            'give the unit in [columns], com_acc_x_mps2 = { column = "…", unit = "g0" }',
        )
    ]  # fmt: skip


def note_differentiated(com_acc_mps2: FloatArray, *, velocity: bool = False) -> list[Finding]:
    """Say that an acceleration (n, 3) that nobody logged is a derivative, and of what."""
    if np.isfinite(com_acc_mps2).any():
        return []
    taken = "derivative of its velocity" if velocity else "second derivative of its position"
    return [
        Finding(
            "acceleration_differentiated", "note", "com_acc",
            f"the log has no acceleration of the CoM: the {taken} is taken",
            "log it too where the estimator has it (com_acc_x_mps2 …): it is less noisy",
        )
    ]  # fmt: skip


def _mean_acceleration(acc_mps2: FloatArray, gravity_mps2: float, where: str) -> list[Finding]:
    """A body that accelerates on average holds gravity, or an offset."""
    mean = acc_mps2.mean(axis=0)
    largest = int(np.argmax(np.abs(mean)))
    if abs(mean[largest]) > MEAN_ACC_MPS2:
        size = abs(float(mean[largest]))
        cause = (
            "gravity is in it"
            if abs(size / gravity_mps2 - 1.0) < 0.3
            else "its unit is wrong, or an offset is in it"
        )
        return [
            _alarm(
                "acceleration_holds_gravity", where,
                f"the CoM accelerates by {mean[largest]:.3g} m/s² along {'xyz'[largest]} on "
                f"average: {cause}",
                "log the acceleration of the CoM in the world without gravity (0 at rest)",
            )
        ]  # fmt: skip
    return []


def _motion_ratio(
    time_s: FloatArray, position: FloatArray, acceleration: FloatArray
) -> tuple[float, float]:
    """Slope and correlation of accelerations on the motion, from windows without gaps."""
    good = np.isfinite(position).all(axis=1) & np.isfinite(acceleration).all(axis=1)
    time_s, position, acceleration = time_s[good], position[good], acceleration[good]
    period = float(np.median(np.diff(time_s))) if time_s.size > 1 else 0.0
    half = MOTION_WINDOW_S / 2
    if not 0.0 < period < half / 3:
        return 1.0, 0.0
    from_position, from_acceleration = [], []
    for middle in np.arange(time_s[0] + half, time_s[-1] - half, half):
        rows = np.flatnonzero(np.abs(time_s - middle) < half)
        if rows.size < 0.8 * 2 * half / period or rows[-1] - rows[0] != rows.size - 1:
            continue
        s = (time_s[rows] - middle) / half
        step = np.gradient(time_s[rows])
        bump = (1.0 - s**2) ** 4
        curved = -8.0 * (1.0 - s**2) ** 3 + 48.0 * s**2 * (1.0 - s**2) ** 2
        line = np.stack([np.ones_like(s), s], axis=1)
        moved = position[rows] - line @ np.linalg.lstsq(line, position[rows], rcond=None)[0]
        from_position.append((step * curved) @ moved / half**2)
        from_acceleration.append((step * bump) @ acceleration[rows])
    if len(from_position) < 5:
        return 1.0, 0.0
    x = np.array(from_position)[:, :2].ravel()
    y = np.array(from_acceleration)[:, :2].ravel()
    x, y = x - x.mean(), y - y.mean()
    size = float(np.sqrt((x @ x) * (y @ y)))
    if not size > 0:
        return 1.0, 0.0
    return float(x @ y) / float(x @ x), float(x @ y) / size


def check_imu(imu_acc_mps2: FloatArray, gravity_mps2: float, where: str) -> list[Finding]:
    """Find a specific force that is in g, or from which gravity was taken off.

    `imu_acc_mps2` has the shape (n, 3).
    """
    size = np.linalg.norm(imu_acc_mps2[np.isfinite(imu_acc_mps2).all(axis=1)], axis=1)
    if size.size < _FEWEST:
        return []
    usual = float(np.median(size))
    if 0.5 < usual / gravity_mps2 < 1.5:
        return []
    in_g = 0.8 < usual < 1.3 and float(np.percentile(size, 10)) > 0.5
    cause = "it looks given in g" if in_g else "gravity was taken off, or its unit is wrong"
    return [
        Finding(
            "imu_without_gravity", "alarm" if in_g or usual > gravity_mps2 else "warning", where,
            f"the specific force at the IMU is {usual:.3g} m/s² (median): {cause}",
            "log imu_acc as the accelerometer reads it, in m/s² (9.8 at rest), or give its unit",
        )
    ]  # fmt: skip


def check_saturation(acc_mps2: FloatArray, where: str) -> list[Finding]:
    """Find an acceleration that stops at the end of its sensor's range.

    Parameters
    ----------
    acc_mps2
        Shape (n, 3).
    """
    axes = [find_cut_impacts(axis) for axis in acc_mps2.T]
    cut = np.any(axes, axis=0)
    limits = {float(x) for i, axis in enumerate(axes) for x in acc_mps2[axis, i]}
    if not limits:
        return []
    return [
        Finding(
            "acceleration_saturated", "warning", where,
            f"{int(cut.sum())} samples stand at the end of the range "
            f"({', '.join(f'{x:.3g}' for x in sorted(limits))} m/s²): impacts were cut off",
            "set a larger range of the accelerometer; what is learnt at landings is not to be "
            "believed",
        )
    ]  # fmt: skip


def check_heading(
    time_s: FloatArray, yaw_rad: FloatArray, where: str,
    feet_m: tuple[FloatArray, FloatArray] | None = None,
) -> list[Finding]:  # fmt: skip
    """Find headings in degrees: the feet contradict them, or they turn too far or too fast.

    The line from foot to foot lies across the heading, however often a robot has turned.

    Parameters
    ----------
    time_s, yaw_rad
        Shape (n,).
    feet_m
        Positions of the left and of the right foot, shape (n, 3) each.
    """
    good = np.isfinite(yaw_rad) & np.isfinite(time_s)
    yaw, time_s = yaw_rad[good], time_s[good]
    if yaw.size < _FEWEST:
        return []
    if feet_m is not None:
        across = (feet_m[0] - feet_m[1])[good]
        off = [_off_across(heading, across) for heading in (yaw, np.radians(yaw))]
        # one heading far from zero may lie across by chance, turns that the feet follow do not
        if off[0] < ACROSS_RAD < off[1] and np.ptp(yaw) > 2.0 * np.pi:
            return []
        if off[0] >= ACROSS_RAD and off[1] <= IN_DEGREES * off[0]:
            return [_in_degrees(where, f"lies {off[0]:.2g} rad off the line across both feet")]
    # jumps by whole turns are a matter of the range, not of the unit
    turned = np.unwrap(yaw)
    furthest = float(np.abs(yaw).max())
    gap = max(round(0.05 / max(float(np.median(np.diff(time_s))), 1e-6)), 1)
    spent = time_s[gap:] - time_s[:-gap]
    moving = spent > 0
    rate = np.abs(turned[gap:] - turned[:-gap])[moving] / spent[moving]
    fastest = float(np.percentile(rate, 99.5)) if rate.size else 0.0
    if furthest <= MOST_TURNS_RAD and fastest <= FASTEST_TURN_RADPS:
        return []
    return [
        _in_degrees(where, f"reaches {furthest:.4g} rad and turns by up to {fastest:.3g} rad/s")
    ]


def _off_across(heading_rad: FloatArray, across_m: FloatArray) -> float:
    """Median angle from headings (n,) to those that lie across a line (n, 3); NaN from too few."""
    off = heading_rad - np.arctan2(across_m[:, 1], across_m[:, 0]) + np.pi / 2.0
    off = np.abs(np.angle(np.exp(1j * off[np.isfinite(off)])))
    return float(np.median(off)) if off.size >= _FEWEST else np.nan


def _in_degrees(where: str, seen: str) -> Finding:
    return _alarm(
        "heading_not_radians", where, f"the heading {seen}: it looks given in degrees",
        'give the unit in [columns], left_foot_yaw_rad = { column = "…", unit = "deg" }',
    )  # fmt: skip


def check_quaternions(quaternion: FloatArray, where: str, *, upright: bool = True) -> list[Finding]:
    """Find quaternions that are no rotations, or given with w first.

    Parameters
    ----------
    quaternion
        x y z w, shape (n, 4).
    upright
        The z axis of what is turned points up; with w first it points elsewhere.
    """
    good = quaternion[np.isfinite(quaternion).all(axis=1)]
    size = np.linalg.norm(good, axis=1)
    if len(good) < 1 or float(np.median(np.abs(size - 1.0))) > 0.05:
        return [] if len(good) < 1 else [
            _alarm(
                "no_unit_quaternions", where,
                f"the quaternions have a norm of {float(np.median(size)):.3g} (median), not 1",
                "check that all four columns are mapped to the right names",
            )
        ]  # fmt: skip
    if not upright:
        return []
    good = good[np.abs(size - 1.0) < 0.1]
    up = float(np.median(rotation_of_quaternion(good)[:, 2, 2]))
    other = float(np.median(rotation_of_quaternion(good[:, [1, 2, 3, 0]])[:, 2, 2]))
    if up > 0.5 or other < 0.9:
        return []
    return [
        _alarm(
            "quaternions_w_first", where,
            f"with the order x y z w it does not stand upright (its z axis rises by {up:.2g}), "
            f"with w first it does ({other:.2g})",
            "map the columns to qx qy qz qw by what they hold: the first one is w",
        )
    ]  # fmt: skip
