"""Recordings of `walk_data` as the package's logs, by the package's own stream handling."""

from __future__ import annotations

import numpy as np

from footcal_cli.core import centroidal, contact, signals
from footcal_cli.core.log import Log
from footcal_cli.core.online.belief import Belief, nameplate
from footcal_cli.core.online.plates import lacking_n
from footcal_cli.core.online.replay import Replayed, corrected
from footcal_cli.core.parameters import FloatArray
from tests.core.walk_data import CELLS_FOOT, CHANNELS, G, Recording, Standing


def walk_log(rec: Recording, compensated_s: float = 0.0, *, causal: bool = False) -> Log:
    """A recording merged onto the cells' clock and filtered, as `online-replay` does it."""
    body = np.concatenate(
        [rec.com, rec.acc, rec.angmom_rate, rec.feet.reshape(-1, 4), rec.yaw], axis=1
    )
    if causal:
        body = signals.low_pass(body, 100.0, causal=True)
    else:
        body[:, 3:8] = signals.low_pass(body[:, 3:8], 100.0)
    merged, usable = signals.interpolate_stream(
        rec.body_time - compensated_s, body, rec.cell_time, max_gap_s=0.05
    )
    counts = signals.low_pass(rec.counts, 80.0, causal=causal)
    force = counts * rec.scale0 + rec.bias0
    per_foot = np.stack([force[:, :4].sum(axis=1), force[:, 4:].sum(axis=1)], axis=1)
    cells = [
        centroidal.points_in_world(merged[:, 8 + 2 * f : 10 + 2 * f], merged[:, 12 + f], CELLS_FOOT)
        for f in range(2)
    ]
    n = len(rec.cell_time)
    if causal:
        standing = contact.contact_now(per_foot, rec.mass * G, 80.0)
        hanging = contact.airborne_now(per_foot, rec.mass * G)
    else:
        standing = contact.detect_contact(per_foot, rec.mass * G, 80.0)
        hanging = contact.airborne(standing)
    return Log(
        "walk",
        CHANNELS,
        rec.cell_time,
        np.where(usable[:, None], counts, np.nan),
        {
            "com_m": merged[:, :3],
            "com_acc_mps2": merged[:, 3:6],
            "angmom_rate_nm": merged[:, 6:8],
            "mass_kg": np.full(n, rec.mass),
            "gravity_mps2": np.full(n, G),
            "cell_pos_m": np.concatenate(cells, axis=1),
            "foot_yaw_rad": merged[:, 12:14],
            "contact": standing,
            "airborne": hanging,
        },
        np.zeros(n, dtype=np.int64),
    )


def turned_world(log: Log, angle_rad: float, shift_m: FloatArray) -> Log:
    """The same recording in a world whose axes point elsewhere."""
    cos, sin = np.cos(angle_rad), np.sin(angle_rad)
    rot = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
    known = dict(log.known)
    for name in ("com_m", "com_acc_mps2", "foot_pos_m", "foot_acc_mps2"):
        if name in known:
            known[name] = known[name] @ rot.T
    if "foot_rot_wt" in known:
        known["foot_rot_wt"] = rot @ known["foot_rot_wt"]
    for name in ("angmom_rate_nm", "cell_pos_m"):
        if name in known:
            known[name] = known[name] @ rot[:2, :2].T
    for name in ("com_m", "cell_pos_m", "foot_pos_m"):
        if name in known:
            known[name] = known[name] + np.resize([*shift_m, 0.0], known[name].shape[-1])
    known["foot_yaw_rad"] = known["foot_yaw_rad"] + angle_rad
    return log.with_known(**known)


def belief_of(made: Recording | Standing, gain_sd: float = 0.02, bias_sd: float = 0.3) -> Belief:
    """What the sensors' nameplate promises."""
    return nameplate(CHANNELS, made.scale0, made.bias0, gain_sd, bias_sd)


FEET_WEIGHTS = ("left.plate_weight", "right.plate_weight")


def true_replay(rec: Recording, log: Log, belief: Belief, plate: float = 0.0) -> Replayed:
    """The floor: the recorded counts read with the true gains and biases."""
    return corrected(
        "true",
        log,
        belief,
        rec.true_gain,
        rec.true_bias,
        lacking_n(log, FEET_WEIGHTS, np.full((len(log), 2), plate)),
    )


def stand_log(made: Standing) -> Log:
    """Quiet stances as a log."""
    n = len(made.time)
    zero = np.zeros
    return Log(
        "stand",
        CHANNELS,
        made.time,
        made.counts,
        {
            "com_m": made.com,
            "com_acc_mps2": zero((n, 3)),
            "angmom_rate_nm": zero((n, 2)),
            "mass_kg": np.full(n, made.mass),
            "gravity_mps2": np.full(n, G),
            "cell_pos_m": made.cells,
            "foot_yaw_rad": made.yaw,
            "contact": made.contact,
        },
        made.stance,
    )
