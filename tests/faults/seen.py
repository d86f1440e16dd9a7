"""What `check` sees: faults of weights, walking, standing and hanging, drawn by seed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd

from tests.faults.bases import BASES, Base
from tests.faults.judging import Case, attempt
from tests.faults.mutations import Mutation
from tests.faults.running import Job, Outcome

Random = np.random.Generator
Change = Callable[[pd.DataFrame, Random], pd.DataFrame]
TIMES = 2
_G = 9.80665
_END = 2.0**23 - 1

BENCH = replace(
    BASES["check_weights"], name="check_bench", recipe="weights.toml",
    words=("check", "weights.csv", "--recipe", "weights.toml", "--quiet"),
)  # fmt: skip
STAND = replace(
    BASES["check_walk"], name="check_stand", logs=("stand_cells.csv", "stand_body.csv"),
    words=("check", "stand_cells.csv", "stand_body.csv", "--recipe", "biped.toml", "--quiet"),
)  # fmt: skip


def _named(log: pd.DataFrame, *endings: str) -> list[str]:
    return [str(name) for name in log.columns if str(name).endswith(endings)]


def _channel(log: pd.DataFrame, rng: Random) -> str:
    return str(rng.choice(_named(log, "_counts", "_n", "_nm")))


def _some_rows(log: pd.DataFrame, rng: Random, share: float) -> slice:
    """A stretch of rows somewhere in the middle."""
    length = int(share * len(log))
    first = int(rng.integers(len(log) // 5, len(log) - length - len(log) // 10))
    return slice(first, first + length)


def outliers(log: pd.DataFrame, rng: Random) -> pd.DataFrame:
    """One to eight samples of one channel read an end code, or many times its range."""
    name = _channel(log, rng)
    values = np.array(log[name], dtype=float)
    far = -(2.0**23) if name.endswith("_counts") else 50.0 * np.abs(values).max()
    values[rng.choice(len(values), int(rng.integers(1, 9)), replace=False)] = far
    return log.assign(**{name: values})


def gap(log: pd.DataFrame, rng: Random) -> pd.DataFrame:
    """A twentieth of the rows is missing."""
    rows = _some_rows(log, rng, 0.05)
    return pd.concat([log.iloc[: rows.start], log.iloc[rows.stop :]])


def stuck(log: pd.DataFrame, rng: Random) -> pd.DataFrame:
    """One channel repeats its reading for a quarter of the log."""
    name, rows = _channel(log, rng), _some_rows(log, rng, 0.25)
    values = np.array(log[name], dtype=float)
    values[rows] = values[rows.start]
    return log.assign(**{name: values})


def dead(log: pd.DataFrame, rng: Random) -> pd.DataFrame:
    """One cell rustles from the first row on."""
    name = _channel(log, rng)
    return log.assign(**{name: np.rint(8.3e6 + 40.0 * rng.standard_normal(len(log)))})


def turned(log: pd.DataFrame, rng: Random) -> pd.DataFrame:
    """One cell reads the other way round its zero."""
    name = _channel(log, rng)
    return log.assign(**{name: 2.0 * log[name].max() - log[name]})


def negated(log: pd.DataFrame, rng: Random) -> pd.DataFrame:
    """One channel is of turned sign."""
    name = _channel(log, rng)
    return log.assign(**{name: -log[name]})


def axis_negated(log: pd.DataFrame, rng: Random) -> pd.DataFrame:
    """One axis of a transducer is of turned sign; one that no orientation loads shows nothing."""
    name = str(rng.choice(["fx_n", "fz_n"]))
    return log.assign(**{name: -log[name]})


def exchanged(log: pd.DataFrame, rng: Random) -> pd.DataFrame:
    """Two cells are exchanged."""
    names = _named(log, "_counts")
    one, other = rng.choice(len(names), 2, replace=False)
    return log.rename(columns={names[one]: names[other], names[other]: names[one]})


def copied_channel(log: pd.DataFrame, rng: Random) -> pd.DataFrame:
    """One channel holds another's readings."""
    names = _named(log, "_counts", "_n")
    one, other = rng.choice(len(names), 2, replace=False)
    return log.assign(**{names[one]: log[names[other]]})


def saturated(log: pd.DataFrame, rng: Random) -> pd.DataFrame:
    """One cell's largest tenth is clipped to the end code of its converter."""
    name = _channel(log, rng)
    return log.assign(**{name: log[name].where(log[name] < log[name].quantile(0.9), _END)})


def lost(log: pd.DataFrame, rng: Random) -> pd.DataFrame:
    """One reading in twenty is empty."""
    name = _channel(log, rng)
    return log.assign(**{name: log[name].where(rng.uniform(size=len(log)) > 0.05)})


def noisy(log: pd.DataFrame, rng: Random) -> pd.DataFrame:
    """A loose contact: one channel scatters by half its range."""
    name = _channel(log, rng)
    span = float(np.ptp(log[name]))
    return log.assign(**{name: log[name] + 0.5 * span * rng.standard_normal(len(log))})


def milliseconds(log: pd.DataFrame, rng: Random) -> pd.DataFrame:
    """Stamps in ms."""
    return log.assign(time_s=1e3 * log["time_s"])


def another_day(log: pd.DataFrame, rng: Random) -> pd.DataFrame:
    """Stamps of another day than the other stream's."""
    return log.assign(time_s=log["time_s"] + 86400.0)


def half_rate(log: pd.DataFrame, rng: Random) -> pd.DataFrame:
    """Stamps counted at half the rate: the stream takes twice as long as the other one."""
    first = log["time_s"].iloc[0]
    return log.assign(time_s=first + 2.0 * (log["time_s"] - first))


def shuffled(log: pd.DataFrame, rng: Random) -> pd.DataFrame:
    """Rows in any order."""
    return log.sample(frac=1, random_state=rng)


def rows_twice(log: pd.DataFrame, rng: Random) -> pd.DataFrame:
    """A tenth of the rows stands there twice."""
    rows = _some_rows(log, rng, 0.1)
    return pd.concat([log.iloc[: rows.stop], log.iloc[rows.start :]])


def joined(log: pd.DataFrame, rng: Random) -> pd.DataFrame:
    """The log stands there twice, one after the other."""
    return pd.concat([log, log])


def frozen(log: pd.DataFrame, rng: Random) -> pd.DataFrame:
    """The whole stream repeats itself for a quarter of the log, its stamps go on."""
    rows = _some_rows(log, rng, 0.25)
    held = log.copy()
    for name in [n for n in _named(log, "") if n != "time_s"]:
        held[name] = np.where(
            np.isin(np.arange(len(log)), np.r_[rows]), log[name].iloc[rows.start], log[name]
        )
    return held


def _times(ending: str, factor: float, plus: float = 0.0) -> Change:
    def change(log: pd.DataFrame, rng: Random) -> pd.DataFrame:
        return log.assign(**{n: factor * log[n] + plus for n in _named(log, ending)})

    return change


def _one_channel(change: Change) -> Change:
    """The fault in the rows of one channel or leg of a long log."""

    def long(log: pd.DataFrame, rng: Random) -> pd.DataFrame:
        key = "channel" if "channel" in log else "leg"
        mine = log[key] == rng.choice(log[key].unique())
        changed = log.astype(dict.fromkeys(_named(log, "counts", "_n", "_nm"), float))
        part = change(changed[mine].rename(columns={"counts": "x_counts"}), rng)
        part = part.rename(columns={"x_counts": "counts"})
        changed.loc[mine, part.columns] = part
        return changed

    return long


def shuffled_readings(log: pd.DataFrame, rng: Random) -> pd.DataFrame:
    """Readings that do not belong to the loads beside them."""
    return log.assign(x_counts=rng.permutation(log["x_counts"].to_numpy()))


def half_turn(log: pd.DataFrame, rng: Random) -> pd.DataFrame:
    """A transducer mounted half a turn off about one of its axes."""
    kept = "xyz"[int(rng.integers(3))]
    names = [f"{q}{a}_{u}" for q, u in (("f", "n"), ("t", "nm")) for a in "xyz" if a != kept]
    return log.assign(**{n: -log[n] for n in names})


def axes_exchanged(log: pd.DataFrame, rng: Random) -> pd.DataFrame:
    """Two axes of a transducer exchanged."""
    return log.rename(columns={"fx_n": "fz_n", "fz_n": "fx_n"})[list(log.columns)]


def orientations_exchanged(log: pd.DataFrame, rng: Random) -> pd.DataFrame:
    """Names of two opposite hangings exchanged."""
    axis = str(rng.choice([o[1] for o in log["orientation"].unique()]))
    names = {f"+{axis}": f"-{axis}", f"-{axis}": f"+{axis}"}
    return log.assign(orientation=log["orientation"].replace(names))


_OF_CELLS: tuple[Change, ...] = (
    outliers, gap, stuck, dead, turned, negated, exchanged, copied_channel, saturated, lost, noisy,
    milliseconds, another_day, half_rate, shuffled, rows_twice, joined, frozen,
)  # fmt: skip
_OF_STANDS = tuple(f for f in _OF_CELLS if f not in {turned, exchanged})
"""Nobody lifts a foot while standing, so nothing shows which way a cell reads."""
_OF_BODIES: tuple[tuple[str, Change], ...] = (
    *((f.__name__, f) for f in (gap, milliseconds, another_day, shuffled, joined, frozen)),
    ("CoM in mm", _times("m_x_m", 1e3)), ("acceleration in g", _times("_mps2", 1.0 / _G)),
    ("gravity in the acceleration", _times("acc_z_mps2", 1.0, _G)),
    ("z down", _times("_z_m", -1.0)),
)  # fmt: skip
_OF_WEIGHTS: tuple[tuple[str, Change], ...] = (
    *((u, _times("load_n", f)) for u, f in (("loads in kg", 1 / _G), ("loads in g", 1e3 / _G),
      ("loads in lbf", 1 / 4.448222), ("loads negative", -1.0), ("loads lost", 0.0))),
    *((f.__name__, _one_channel(f)) for f in (outliers, dead, negated, saturated, stuck,
      shuffled_readings)),
    ("milliseconds", _times("time_s", 1e3)), ("rows_twice", rows_twice),
)  # fmt: skip
_OF_HANGINGS: tuple[tuple[str, Change], ...] = (
    *((f.__name__, _one_channel(f)) for f in (outliers, stuck, axis_negated, lost, half_turn,
      axes_exchanged)),
    *((f.__name__, f) for f in (milliseconds, shuffled, rows_twice, orientations_exchanged)),
)  # fmt: skip


def seen_jobs(inputs: Path, seed: int) -> list[Job]:
    """Every fault in every kind of log, `TIMES` times."""
    walk, hang = BASES["check_walk"], BASES["check_hang"]
    tried: list[tuple[Base, str, str, Change]] = []
    for base, log, faults in (
        (walk, "walk_cells.csv", [(f.__name__, f) for f in _OF_CELLS]),
        (walk, "walk_body.csv", _OF_BODIES),
        (STAND, "stand_cells.csv", [(f.__name__, f) for f in _OF_STANDS]),
        (BENCH, "weights.csv", _OF_WEIGHTS),
        (hang, "hang.csv", _OF_HANGINGS),
    ):
        tried += [(base, log, name.replace("_", " "), change) for name, change in faults]
    return [
        Job(f"{base.name} | {log}: {name} | seen {seed + k}", "seen", log,
            look(base, log, name, change, seed + k, inputs))
        for base, log, name, change in tried
        for k in range(TIMES)
    ]  # fmt: skip


def look(
    base: Base, log: str, name: str, change: Change, seed: int, inputs: Path, part: str = "seen"
) -> Callable[[Path], Outcome]:
    """What `check` says of a log with this fault."""

    def bend(path: Path, rng: Random) -> None:
        change(pd.read_csv(path), rng).to_csv(path, index=False)

    def run(folder: Path) -> Outcome:
        fault = Mutation("seen", name, bend, wrong=True)
        outcome = attempt(Case(base, log, fault, seed), inputs, folder)
        key = f"{base.name} | {log}: {name} | {part} {seed}"
        return replace(outcome, key=key, part=part, family=log)

    return run
