"""A second set of faults for `check`: written down before anybody saw what it says of them.

Six of each experiment, none of them in `tests.faults.seen`; what happens at a bench, on a robot or
to a file. Injected into the clean sample logs by seed; `check` runs once on each.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd

from tests.faults.bases import BASES
from tests.faults.running import Job
from tests.faults.seen import BENCH, STAND, Change, Random, look

TIMES = 2
_CELLS = ("fl", "fr", "rl", "rr")
PLACED = replace(
    BASES["check_weights"], name="check_placements", logs=("weights.csv", "placements.csv"),
    recipe="foot.toml",
    words=("check", "weights.csv", "placements.csv", "--recipe", "foot.toml", "--quiet"),
)  # fmt: skip
POSES = replace(
    BASES["check_hang"], name="check_poses", logs=("poses.csv",),
    words=("check", "poses.csv", "--recipe", "hexapod.toml", "--quiet"),
)  # fmt: skip


def _mine(log: pd.DataFrame, rng: Random, key: str) -> np.ndarray:
    """Rows of one channel, leg, placement or pose, drawn."""
    return np.asarray(log[key] == rng.choice(log[key].unique()))


def _later(rows: np.ndarray) -> np.ndarray:
    """The second half of these rows."""
    found = np.flatnonzero(rows)
    later = np.zeros_like(rows)
    later[found[found.size // 2 :]] = True
    return later


def _cell(log: pd.DataFrame, rng: Random) -> str:
    return str(rng.choice([n for n in log.columns if str(n).endswith("_counts")]))


# weights -----------------------------------------------------------------------------------------


def load_mistyped(log: pd.DataFrame, rng: Random) -> pd.DataFrame:
    """One load of one cell written down as another one of the set."""
    mine = _mine(log, rng, "channel")
    was, new = rng.choice(log["load_n"].unique(), 2, replace=False)
    at = mine & (log["load_n"] == was)
    return log.assign(load_n=log["load_n"].mask(at, new))


def zeroed_midway(log: pd.DataFrame, rng: Random) -> pd.DataFrame:
    """From the middle on one cell was set to zero again: readings move by 0.2 ranges."""
    mine = _mine(log, rng, "channel")
    span = float(np.ptp(log.loc[mine, "counts"]))
    return log.assign(counts=log["counts"] + 0.2 * span * _later(mine))


def gain_midway(log: pd.DataFrame, rng: Random) -> pd.DataFrame:
    """From the middle on the converter of one cell runs at half its gain."""
    later = _later(_mine(log, rng, "channel"))
    return log.assign(counts=log["counts"].where(~later, log["counts"] / 2.0))


def not_settled(log: pd.DataFrame, rng: Random) -> pd.DataFrame:
    """Readings of one cell taken too early: a third of the change since the last one is lacking."""
    mine = np.flatnonzero(_mine(log, rng, "channel"))
    counts = log["counts"].to_numpy(dtype=float)
    counts[mine[1:]] -= np.diff(counts[mine]) / 3.0
    return log.assign(counts=counts)


def cells_exchanged_midway(log: pd.DataFrame, rng: Random) -> pd.DataFrame:
    """The readings of one load of two cells stand under each other's name."""
    one, other = rng.choice(log["channel"].unique(), 2, replace=False)
    load = rng.choice(log["load_n"].unique()[2:])
    at = log["load_n"] == load
    names = log["channel"].where(~at, log["channel"].replace({one: other, other: one}))
    return log.assign(channel=names)


def three_digits(log: pd.DataFrame, rng: Random) -> pd.DataFrame:
    """Readings written with three digits (8.14e6)."""
    return log.assign(counts=[float(f"{x:.3g}") for x in log["counts"]])


# placements --------------------------------------------------------------------------------------


def holes_exchanged(log: pd.DataFrame, rng: Random) -> pd.DataFrame:
    """Two holes written down for each other."""
    one, other = rng.choice(log["placement"].unique(), 2, replace=False)
    where = log.groupby("placement")[["hole_x_m", "hole_y_m"]].first()
    names = log["placement"].replace({one: other, other: one})
    return log.assign(**{str(a): names.map(where[a]) for a in where})


def axes_of_holes(log: pd.DataFrame, rng: Random) -> pd.DataFrame:
    """x and y of the holes exchanged."""
    return log.assign(hole_x_m=log["hole_y_m"], hole_y_m=log["hole_x_m"])


def holes_mirrored(log: pd.DataFrame, rng: Random) -> pd.DataFrame:
    """The plate of holes was mounted left for right."""
    return log.assign(hole_y_m=-log["hole_y_m"])


def holes_from_the_heel(log: pd.DataFrame, rng: Random) -> pd.DataFrame:
    """Holes measured from the rear edge, not from the middle of the foot."""
    return log.assign(hole_x_m=log["hole_x_m"] + 0.07)


def other_weight(log: pd.DataFrame, rng: Random) -> pd.DataFrame:
    """One placement's loads are those of another set of weights, a third lighter."""
    at = _mine(log, rng, "placement")
    return log.assign(load_n=log["load_n"].where(~at, log["load_n"] / 1.5))


def one_cell_off(log: pd.DataFrame, rng: Random) -> pd.DataFrame:
    """At one placement one cell lost its contact: it reads as without a load."""
    at, name = _mine(log, rng, "placement"), f"{rng.choice(_CELLS)}_counts"
    return log.assign(**{name: log[name].where(~at, log[name].max())})


# streams of cells --------------------------------------------------------------------------------


def bit_lost(log: pd.DataFrame, rng: Random) -> pd.DataFrame:
    """One bit of one channel's word is always zero, an eighth of its range."""
    name = _cell(log, rng)
    bit = 1 << max(int(np.log2(np.ptp(log[name]) / 8)), 0)
    return log.assign(**{name: log[name].astype(int) & ~bit})


def wrapped(log: pd.DataFrame, rng: Random) -> pd.DataFrame:
    """One channel kept the low 16 bits alone."""
    name = _cell(log, rng)
    return log.assign(**{name: log[name].astype(int) & 0xFFFF})


def hum(log: pd.DataFrame, rng: Random) -> pd.DataFrame:
    """Hum of the mains on one channel, a tenth of its range."""
    name = _cell(log, rng)
    wave = np.sin(2 * np.pi * 49.3 * log["time_s"] + rng.uniform(0, 6))
    return log.assign(**{name: log[name] + 0.1 * np.ptp(log[name]) * wave})


def warming_up(log: pd.DataFrame, rng: Random) -> pd.DataFrame:
    """One channel drifts by a third of its range over the log."""
    name = _cell(log, rng)
    return log.assign(**{name: log[name] + np.ptp(log[name]) / 3 * np.linspace(0, 1, len(log))})


def let_go(log: pd.DataFrame, rng: Random) -> pd.DataFrame:
    """From the middle on one gauge follows with half its gain."""
    name = _cell(log, rng)
    later = np.arange(len(log)) > len(log) // 2
    zero = log[name].max()
    return log.assign(**{name: log[name].where(~later, zero + (log[name] - zero) / 2)})


def coarse(log: pd.DataFrame, rng: Random) -> pd.DataFrame:
    """All readings written with three digits (8.14e6)."""
    names = [n for n in log.columns if str(n).endswith("_counts")]
    return log.assign(**{n: [float(f"{x:.3g}") for x in log[n]] for n in names})


def feet_exchanged(log: pd.DataFrame, rng: Random) -> pd.DataFrame:
    """The plugs of the two feet are exchanged."""
    sides = {"left": "right", "right": "left"}
    names = {
        n: f"{sides[n.partition('_')[0]]}_{n.partition('_')[2]}"
        for n in log.columns if str(n).partition("_")[0] in sides
    }  # fmt: skip
    return log.rename(columns=names)


def foot_late(log: pd.DataFrame, rng: Random) -> pd.DataFrame:
    """One foot's samples come a quarter of a second after the other's."""
    side = str(rng.choice(["left", "right"]))
    names = [n for n in log.columns if str(n).startswith(f"{side}_") and "counts" in str(n)]
    step = float(np.median(np.diff(log["time_s"])))
    return log.assign(**{n: log[n].shift(round(0.25 / step)).bfill() for n in names})


def in_bursts(log: pd.DataFrame, rng: Random) -> pd.DataFrame:
    """Stamps of the arrival: packets of a quarter of a second, all rows of one at one time."""
    return log.assign(time_s=np.ceil(log["time_s"] / 0.25) * 0.25)


def clock_set(log: pd.DataFrame, rng: Random) -> pd.DataFrame:
    """The clock was set back by 0.4 s in the middle of the log."""
    later = np.arange(len(log)) > len(log) // 2
    return log.assign(time_s=log["time_s"] - 0.4 * later)


def held_by_a_hand(log: pd.DataFrame, rng: Random) -> pd.DataFrame:
    """For a tenth of the log a hand carries a third of the robot."""
    first = int(rng.integers(len(log) // 4, len(log) // 2))
    rows = np.isin(np.arange(len(log)), np.arange(first, first + len(log) // 10))
    changed = {
        n: log[n].where(~rows, log[n] + (8.32e6 - log[n]) / 3)
        for n in log.columns if str(n).endswith("_counts")
    }  # fmt: skip
    return log.assign(**changed)


# bodies ------------------------------------------------------------------------------------------


def feet_of_the_body_exchanged(log: pd.DataFrame, rng: Random) -> pd.DataFrame:
    """Left and right foot exchanged in the stream of the body."""
    return feet_exchanged(log, rng)


def com_in_another_frame(log: pd.DataFrame, rng: Random) -> pd.DataFrame:
    """The CoM in odometry, the feet on the map: a metre and a half apart."""
    return log.assign(com_x_m=log["com_x_m"] + 1.2, com_y_m=log["com_y_m"] - 0.9)


def acceleration_turned(log: pd.DataFrame, rng: Random) -> pd.DataFrame:
    """Horizontal accelerations of turned sign."""
    return log.assign(com_acc_x_mps2=-log["com_acc_x_mps2"], com_acc_y_mps2=-log["com_acc_y_mps2"])


# hangings ----------------------------------------------------------------------------------------


def degrees(log: pd.DataFrame, rng: Random) -> pd.DataFrame:
    """Phases in degrees."""
    return log.assign(phase_rad=np.degrees(log["phase_rad"]))


def legs_exchanged(log: pd.DataFrame, rng: Random) -> pd.DataFrame:
    """In one orientation two legs' plugs are exchanged, a left and a right one."""
    at = _mine(log, rng, "orientation")
    names = {"fl": "fr", "fr": "fl"}
    return log.assign(leg=log["leg"].where(~at, log["leg"].replace(names)))


def zeroed_between(log: pd.DataFrame, rng: Random) -> pd.DataFrame:
    """One leg's transducer was set to zero while it hung in one orientation."""
    at = _mine(log, rng, "leg") & _mine(log, rng, "orientation")
    names = [n for n in log.columns if str(n).endswith(("_n", "_nm"))]
    return log.assign(**{n: log[n].where(~at, log[n] - log.loc[at, n].mean()) for n in names})


def decimal_point(log: pd.DataFrame, rng: Random) -> pd.DataFrame:
    """One channel of one leg reads ten times too much."""
    at, name = _mine(log, rng, "leg"), str(rng.choice(["fx_n", "fz_n"]))
    return log.assign(**{name: log[name].where(~at, 10.0 * log[name])})


def torques_in_nmm(log: pd.DataFrame, rng: Random) -> pd.DataFrame:
    """Torques in Nmm."""
    return log.assign(**{n: 1e3 * log[n] for n in ("tx_nm", "ty_nm", "tz_nm")})


def touched_the_stand(log: pd.DataFrame, rng: Random) -> pd.DataFrame:
    """One leg rested on the stand in one orientation: half its weight is not seen."""
    at = _mine(log, rng, "leg") & _mine(log, rng, "orientation")
    names = [n for n in log.columns if str(n).endswith(("_n", "_nm"))]
    return log.assign(**{n: log[n].where(~at, log[n] / 2) for n in names})


# poses -------------------------------------------------------------------------------------------


def conjugated(log: pd.DataFrame, rng: Random) -> pd.DataFrame:
    """Attitudes the other way round, world to body."""
    return log.assign(**{f"body_q{a}": -log[f"body_q{a}"] for a in "xyz"})


def next_attitude(log: pd.DataFrame, rng: Random) -> pd.DataFrame:
    """Every pose has the attitude of the one after the next."""
    names = [f"body_q{a}" for a in "xyzw"]
    return log.assign(**{n: log[n].shift(-12).ffill() for n in names})


def contact_inverted(log: pd.DataFrame, rng: Random) -> pd.DataFrame:
    """The column of contacts says 1 in the air."""
    return log.assign(contact=1 - log["contact"])


def leg_frozen(log: pd.DataFrame, rng: Random) -> pd.DataFrame:
    """One leg's wrench is that of the first pose for half of them."""
    later = _later(_mine(log, rng, "leg"))
    names = [n for n in log.columns if str(n).endswith(("_n", "_nm"))]
    first = log[later].iloc[0]
    return log.assign(**{n: log[n].where(~later, first[n]) for n in names})


def on_a_rail(log: pd.DataFrame, rng: Random) -> pd.DataFrame:
    """In some poses the belly lay on something: 40 % of the robot is not seen."""
    poses = rng.choice(log["pose"].unique(), 6, replace=False)
    at = np.asarray(log["pose"].isin(poses))
    names = [n for n in log.columns if str(n).endswith(("_n", "_nm"))]
    return log.assign(**{n: log[n].where(~at, 0.6 * log[n]) for n in names})


def kilograms_force(log: pd.DataFrame, rng: Random) -> pd.DataFrame:
    """Forces of one leg in kgf."""
    at = _mine(log, rng, "leg")
    return log.assign(**{n: log[n].where(~at, log[n] / 9.80665) for n in ("fx_n", "fy_n", "fz_n")})


STANDS: tuple[Change, ...] = (bit_lost, wrapped, hum, warming_up, coarse, held_by_a_hand)
WALKS: tuple[Change, ...] = (feet_exchanged, foot_late, in_bursts, clock_set, let_go, bit_lost)
BODIES: tuple[Change, ...] = (
    feet_of_the_body_exchanged, com_in_another_frame, acceleration_turned,
)  # fmt: skip
WEIGHTS: tuple[Change, ...] = (
    load_mistyped, zeroed_midway, gain_midway, not_settled, cells_exchanged_midway, three_digits,
)  # fmt: skip
PLACEMENTS: tuple[Change, ...] = (
    holes_exchanged, axes_of_holes, holes_mirrored, holes_from_the_heel, other_weight, one_cell_off,
)  # fmt: skip
HANGS: tuple[Change, ...] = (
    degrees, legs_exchanged, zeroed_between, decimal_point, torques_in_nmm, touched_the_stand,
)  # fmt: skip
IN_POSES: tuple[Change, ...] = (
    conjugated, next_attitude, contact_inverted, leg_frozen, on_a_rail, kilograms_force,
)  # fmt: skip


def unseen_jobs(inputs: Path, seed: int) -> list[Job]:
    """Every fault, `TIMES` times."""
    tried = [
        (base, log, change)
        for base, log, changes in (
            (BENCH, "weights.csv", WEIGHTS),
            (PLACED, "placements.csv", PLACEMENTS),
            (STAND, "stand_cells.csv", STANDS),
            (BASES["check_walk"], "walk_cells.csv", WALKS),
            (BASES["check_walk"], "walk_body.csv", BODIES),
            (BASES["check_hang"], "hang.csv", HANGS),
            (POSES, "poses.csv", IN_POSES),
        )
        for change in changes
    ]
    return [
        Job(f"{base.name} | {log}: {name} | unseen {seed + k}", "unseen", log,
            look(base, log, name, change, seed + k, inputs, "unseen"))
        for base, log, change in tried
        for name in [change.__name__.replace("_", " ")]
        for k in range(TIMES)
    ]  # fmt: skip
