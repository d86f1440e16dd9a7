"""Two transducers in series on one stiff leg: what their readings say of each other.

Between them lies a segment of weight W_s: ``w_2 − o_2 = T (w_1 − o_1) + [W_s ĝ; …]``. Without the
direction of gravity the segment's weight cannot be distinguished from the offsets, and of the
twelve offsets only the combination ``o_2 − T o_1`` (with the segment's weight in it) is seen.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.spatial import rotation_log, skew

SEEN, UNKNOWN = 6, 12


@dataclass(frozen=True)
class SeriesFit:
    """What two transducers in series say.

    Parameters
    ----------
    rot_21
        Rotation first to second, from how their forces change together, shape (3, 3).
    pos_2_m
        Origin of the first in the second's frame, from the torques, shape (3,), m.
    combination, combination_sd
        ``o_2 − T o_1`` with the segment's weight in it, in quiet standing, shape (6,).
    left
        ``w_2 − T w_1 − combination`` per block of samples, shape (b, 6).
    change
        How much the second's readings change in the log, sd, shape (6,).
    explained
        Part of the change of force that the first transducer explains.
    """

    first: str
    second: str
    rot_21: FloatArray
    pos_2_m: FloatArray
    combination: FloatArray
    combination_sd: FloatArray
    left: FloatArray
    change: FloatArray
    explained: float

    @property
    def turn_deg(self) -> float:
        """Angle between the two frames."""
        return float(np.rad2deg(np.linalg.norm(rotation_log(self.rot_21))))

    @property
    def force_left_n(self) -> float:
        """Force per axis that stays unexplained, RMS."""
        return float(np.sqrt(np.mean(self.left[:, :3] ** 2)))


def series_means(columns: FloatArray, rows: int) -> FloatArray:
    """Means of consecutive blocks of `rows` samples, shape (n // rows, c)."""
    count = columns.shape[0] // rows
    return np.asarray(columns[: count * rows].reshape(count, rows, -1).mean(axis=1))


def fit_series(
    first: str,
    second: str,
    wrench_1: FloatArray,
    wrench_2: FloatArray,
    quiet_rows: int,
    block_rows: int,
) -> SeriesFit:
    """Relative mounting from a log in which the load changes, offsets' combination from its start.

    Rotation by Kabsch's method on the changes of force, translation by least squares on the
    changes of torque.

    Parameters
    ----------
    wrench_1, wrench_2
        Readings, shape (n, 6), N and Nm; quiet standing first.
    quiet_rows
        Rows at the start in which nothing moves.
    block_rows
        Rows averaged together: quasi-static changes only.
    """
    one, two = series_means(wrench_1, block_rows), series_means(wrench_2, block_rows)
    change_1, change_2 = one - one.mean(axis=0), two - two.mean(axis=0)
    left, _, right = np.linalg.svd(change_2[:, :3].T @ change_1[:, :3])
    rot = left @ np.diag([1.0, 1.0, np.linalg.det(left @ right)]) @ right
    force = change_1[:, :3] @ rot.T
    torque = change_2[:, 3:] - change_1[:, 3:] @ rot.T
    lever = -skew(force).reshape(-1, 3)
    pos = np.linalg.lstsq(lever, torque.ravel(), rcond=None)[0]

    def carried(wrench: FloatArray) -> FloatArray:
        turned = wrench[:, :3] @ rot.T
        return np.hstack([turned, wrench[:, 3:] @ rot.T + np.cross(pos, turned)])

    quiet = series_means(wrench_2[:quiet_rows] - carried(wrench_1[:quiet_rows]), block_rows)
    count = max(quiet.shape[0], 1)
    combination = quiet.mean(axis=0)
    sd = quiet.std(axis=0, ddof=1) / np.sqrt(count) if count > 1 else np.full(6, np.nan)
    rest = two - carried(one) - combination
    moving = change_2[:, :3] - force
    explained = 1.0 - float(np.sum(moving**2) / max(np.sum(change_2[:, :3] ** 2), 1e-300))
    return SeriesFit(
        first, second, rot, pos, combination, sd, rest, change_2.std(axis=0), explained
    )


def series_words(fit: SeriesFit) -> tuple[str, ...]:
    """What can be said of this pair, and what cannot."""
    pair = f"{fit.first} and {fit.second}"
    weight = " ".join(f"{value:+.1f}" for value in fit.combination[:3])
    return (
        f"{pair}: of their {UNKNOWN} offsets only one combination of {SEEN} is seen, the offset of "
        f"{fit.second} minus that of {fit.first} turned into it, with the weight of what lies "
        f"between them in it ({weight} N); each one's own offset is not seen",
        f"{pair}: {100 * fit.explained:.0f} % of the change of force agrees between them; "
        f"{fit.force_left_n:.1f} N per axis does not. The weight of the segment between them, "
        "turning with the leg, or a hand on it would do that: without the body's orientation "
        "neither can be distinguished from a wrong gain",
    )
