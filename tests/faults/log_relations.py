"""Relations of logs: another spelling, unit, order or cut of the same content."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path

import numpy as np
import pandas as pd

from tests.faults.bases import BASES
from tests.faults.facts import Facts
from tests.faults.relations import GEOMETRY, ROUNDED, Relation, Words, bases_of, of_logs, read_log


def log_relations() -> list[Relation]:
    """All of them."""
    return [*_spellings(), *_units(), *_rows(), *_clocks()]


# another spelling of the same content

_LOGGED = (
    "weights", "placements", "stream", "together", "stand", "walk", "hang", "pose", "apply",
    "apply_legs", "check_weights", "check_walk", "check_hang", "diagnose", "kinematics",
)  # fmt: skip


def _spellings() -> Iterator[Relation]:
    def parquet(folder: Path, words: Words) -> Words:
        return _respelt(words, ".parquet", lambda log, path: log.to_parquet(path))

    def packed(folder: Path, words: Words) -> Words:
        return _respelt(words, ".csv.gz", lambda log, path: log.to_csv(path, index=False))

    def windows(folder: Path, words: Words) -> Words:
        for word in words:
            path = Path(word)
            if path.suffix in {".csv", ".toml", ".json"}:
                path.write_bytes(path.read_bytes().replace(b"\n", b"\r\n"))
        return words

    def turned(log: pd.DataFrame) -> pd.DataFrame:
        return log[list(log.columns[::-1])]

    def more(log: pd.DataFrame) -> pd.DataFrame:
        return log.assign(note="a remark", battery_v=np.linspace(24, 22, len(log)))

    for base in bases_of(*_LOGGED):
        yield Relation("columns in the opposite order", "columns", base, of_logs(turned))
        yield Relation("columns that nobody asked for", "columns", base, of_logs(more))
        yield Relation("Parquet instead of CSV", "format", base, parquet)
        yield Relation("CSV packed by gzip", "format", base, packed)
        yield Relation("line ends of Windows", "format", base, windows)


def _respelt(
    words: Words, ending: str, write: Callable[[pd.DataFrame, Path], object]
) -> Words:  # fmt: skip
    new = []
    for word in words:
        if word.endswith(".csv"):
            path = Path(word.removesuffix(".csv") + ending)
            write(read_log(Path(word)), path)
            Path(word).unlink()
            word = str(path)
        new.append(word)
    return new


# another unit, another name

_FACTORS = {
    "_load_n": ("_load_kg", 1 / 9.80665), "load_n": ("load_g", 1e3 / 9.80665),
    "hole_x_m": ("hole_x_mm", 1e3), "hole_y_m": ("hole_y_cm", 1e2), "time_s": ("time_ms", 1e3),
    "com_x_m": ("com_x_mm", 1e3), "com_z_m": ("com_z_cm", 1e2),
    "_yaw_rad": ("_yaw_deg", 180 / np.pi), "_foot_x_m": ("_foot_x_mm", 1e3),
    "phase_rad": ("phase_deg", 180 / np.pi),
    "fx_n": ("fx_mn", 1e3), "fy_n": ("fy_kgf", 1 / 9.80665),
    "fz_n": ("fz_lbf", 1 / 4.4482216152605),
    "tx_nm": ("tx_nmm", 1e3), "ty_nm": ("ty_nmm", 1e3), "tz_nm": ("tz_nmm", 1e3),
}  # fmt: skip


def _units() -> Iterator[Relation]:
    def in_unit(ending: str, log: pd.DataFrame) -> pd.DataFrame:
        new, factor = _FACTORS[ending]
        for name in [n for n in log.columns if n.endswith(ending) and "true" not in n]:
            log[name] = log[name] * factor
            log = log.rename(columns={name: name.removesuffix(ending) + new})
        return log

    asked = {
        "weights": ("load_n",), "placements": ("load_n", "hole_x_m", "hole_y_m"),
        "stream": ("load_n", "time_s"), "together": ("_load_n",),
        "stand": ("time_s", "com_x_m", "com_z_m", "_foot_x_m", "_yaw_rad"),
        "walk": ("time_s", "com_x_m", "_foot_x_m"),
        "hang": ("time_s", "phase_rad", "fx_n", "fy_n", "fz_n", "tx_nm", "ty_nm", "tz_nm"),
        "pose": ("phase_rad", "fx_n", "fz_n", "tx_nm"), "apply": ("time_s",),
        "apply_legs": ("phase_rad", "fy_n", "ty_nm"), "diagnose": ("load_n",),
    }  # fmt: skip
    for name, endings in asked.items():
        base = BASES[name]
        for ending in endings:
            yield Relation(
                f"{ending.strip('_')} as {_FACTORS[ending][0].strip('_')}", "unit", base,
                of_logs(partial(in_unit, ending)),
                # the noise of a diagnosis and its effects are found by iteration, to 0.02 sd
                GEOMETRY if name == "diagnose" else ROUNDED, words=name != "check_weights",
            )  # fmt: skip
    for base in bases_of(*_LOGGED):
        if base.recipe and base.name not in {"kinematics", "batch"}:
            yield Relation("every column under a foreign name", "columns", base, _foreign_names)


def _foreign_names(folder: Path, words: Words) -> Words:
    names: dict[str, str] = {}
    for word in words:
        if word.endswith(".csv"):
            log = read_log(Path(word))
            names |= {n: f"Signal {len(names) + i} (raw)" for i, n in enumerate(log.columns)
                      if n not in names}  # fmt: skip
            log.rename(columns=names).to_csv(word, index=False)
    (recipe,) = [Path(word) for word in words if word.endswith(".toml")]
    wanted = {n: f for n, f in names.items() if not n.endswith("_true_n")}
    table = "\n".join(f"{name} = {json.dumps(foreign)}" for name, foreign in wanted.items())
    recipe.write_text(f"{recipe.read_text('utf-8')}\n[columns]\n{table}\n", "utf-8")
    return words


# rows and files

_ORDER_FREE = ("weights", "together", "check_weights")


_SPLIT_BY_TIME = ("stream", "stand", "walk", "apply", "check_walk")
"""Not hanging logs: each file is a hanging of its own there, with its own tilt."""


def _rows() -> Iterator[Relation]:
    def shuffled(log: pd.DataFrame) -> pd.DataFrame:
        return log.sample(frac=1, random_state=3)

    def twice(folder: Path, words: Words) -> Words:
        copies = []
        for word in [w for w in words if w.endswith(".csv")]:
            copy = folder / f"copy_of_{Path(word).name}"
            copy.write_bytes(Path(word).read_bytes())
            copies.append(str(copy))
        return [*words, *copies]

    def part(folder: Path, words: Words) -> Words:
        (word,) = [w for w in words if w.endswith(".csv")]
        part = folder / "part.csv"
        read_log(Path(word)).iloc[::3].to_csv(part, index=False)
        return [words[0], str(part), *words[1:]]

    def halves(by: str, folder: Path, words: Words) -> Words:
        (word,) = [w for w in words if w.endswith(".csv") and by in read_log(Path(w))]
        log = read_log(Path(word))
        groups = list(dict.fromkeys(log[by]))
        one = log[by].isin(groups[: len(groups) // 2])
        paths = []
        for i, piece in enumerate((log[one], log[~one])):
            paths.append(str(folder / f"half_{i}.csv"))
            piece.to_csv(paths[-1], index=False)
        at = words.index(word)
        return [*words[:at], *paths, *words[at + 1 :]]

    def by_time(folder: Path, words: Words) -> Words:
        new: Words = []
        for word in words:
            if word.endswith(".csv") and "time_s" in read_log(Path(word)):
                log = read_log(Path(word))
                early = log["time_s"] < log["time_s"].median()
                for i, piece in enumerate((log[early], log[~early])):
                    new.append(str(folder / f"{Path(word).stem}_part_{i}.csv"))
                    piece.to_csv(new[-1], index=False)
            else:
                new.append(word)
        return new

    def swapped(folder: Path, words: Words) -> Words:
        logs = [w for w in words if w.endswith(".csv")]
        return [words[0], *logs[::-1], *(w for w in words[1:] if w not in logs)]

    def within_poses(log: pd.DataFrame) -> pd.DataFrame:
        return log.sample(frac=1, random_state=3).sort_values("pose", kind="stable")

    for base in bases_of(*_ORDER_FREE):
        yield Relation("rows in another order", "rows", base, of_logs(shuffled), ROUNDED)
    # poses stand in the order of their recording: what drifts from pose to pose is known by it
    for base in bases_of("pose"):
        yield Relation("legs of a pose in another order", "rows", base, of_logs(within_poses),
                       ROUNDED)  # fmt: skip
    for base in bases_of("weights", "placements", "stream", "together", "stand", "walk", "hang",
                       "pose", "diagnose"):  # fmt: skip
        yield Relation("every log given twice", "copies", base, twice, words=False)
    for base in bases_of("weights", "together", "pose"):
        yield Relation("a third of the rows given twice", "copies", base, part, words=False)
    for name, by in (("weights", "channel"), ("hang", "orientation"), ("pose", "pose"),
                     ("diagnose", "channel"), ("check_weights", "channel")):  # fmt: skip
        yield Relation(
            f"in two files, by {by}", "files", BASES[name], partial(halves, by), ROUNDED,
            words=False,
        )  # fmt: skip
    for base in bases_of(*_SPLIT_BY_TIME):
        yield Relation(
            "each stream in two files, by time", "files", base, by_time, ROUNDED, words=False
        )
    for base in bases_of("placements", "stand", "walk", "check_walk"):
        yield Relation("logs named in another order", "files", base, swapped)


# clocks


def _clocks() -> Iterator[Relation]:
    def later(by_s: float, log: pd.DataFrame) -> pd.DataFrame:
        return log.assign(time_s=log["time_s"] + by_s) if "time_s" in log else log

    for name in ("stream", "stand", "walk", "hang", "apply", "apply_legs", "check_walk"):
        for by_s in (1024.0, 2.0**30):  # powers of two: the stamps stay as exact as they can
            yield Relation(
                f"all stamps {by_s:.0f} s later", "clock", BASES[name],
                of_logs(partial(later, by_s)), ROUNDED,
                expected=partial(_later_stamps, by_s),
            )  # fmt: skip


def _later_stamps(by_s: float, facts: Facts) -> Facts:
    """Stamps of the answer move along."""
    numbers = {
        name: (value + by_s if name.endswith("/time_s") else value, sd)
        for name, (value, sd) in facts.numbers.items()
    }
    return Facts(numbers, facts.words)
