"""Typed mutations of valid inputs; each says what the program may do with it."""

from __future__ import annotations

import gzip
import json
import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

REFUSED = frozenset({2, 3})
ANY = frozenset({0, 1, 2, 3})

FloatArray = np.ndarray[Any, np.dtype[Any]]
Bend = Callable[[Path, np.random.Generator], None]


@dataclass(frozen=True)
class Mutation:
    """One way of spoiling a file.

    Parameters
    ----------
    family, name
        Class of fault and its name.
    bend
        Spoils the file in place.
    codes
        Exit codes that are acceptable.
    harmless
        The content means the same: numbers may not move, whatever the verdict.
    wrong
        Physically wrong: exit 0 needs a warning, an alarm or a verdict that is not good.
    """

    family: str
    name: str
    bend: Bend
    codes: frozenset[int] = ANY
    harmless: bool = False
    wrong: bool = False


def _bytes(change: Callable[[bytes, np.random.Generator], bytes]) -> Bend:
    def bend(path: Path, rng: np.random.Generator) -> None:
        path.write_bytes(change(path.read_bytes(), rng))

    return bend


def _table(change: Callable[[pd.DataFrame, np.random.Generator], pd.DataFrame]) -> Bend:
    def bend(path: Path, rng: np.random.Generator) -> None:
        change(pd.read_csv(path), rng).to_csv(path, index=False)

    return bend


def _numeric(log: pd.DataFrame, rng: np.random.Generator) -> str:
    names = [n for n in log.columns if log[n].dtype.kind in "if"]
    return str(rng.choice(names))


def _cell(value: object) -> Bend:
    def change(log: pd.DataFrame, rng: np.random.Generator) -> pd.DataFrame:
        name = _numeric(log, rng)
        values = log[name].to_numpy(dtype=object)
        values[int(rng.integers(len(log)))] = value
        return log.assign(**{name: values})

    return _table(change)


def _column(change: Callable[[FloatArray], FloatArray]) -> Bend:
    def whole(log: pd.DataFrame, rng: np.random.Generator) -> pd.DataFrame:
        name = _numeric(log, rng)
        return log.assign(**{name: change(log[name].to_numpy())})

    return _table(whole)


def _stamps(change: Callable[[FloatArray], FloatArray]) -> Bend:
    def whole(log: pd.DataFrame, rng: np.random.Generator) -> pd.DataFrame:
        return log.assign(time_s=change(log["time_s"].to_numpy())) if "time_s" in log else log

    return _table(whole)


def _scaled(kind: str, factor: float) -> Bend:
    def whole(log: pd.DataFrame, rng: np.random.Generator) -> pd.DataFrame:
        names = [n for n in log.columns if n.endswith(kind) and "true" not in n]
        return log.assign(**{n: log[n] * factor for n in names})

    return _table(whole)


def _renamed(rename: Callable[[str], str]) -> Bend:
    def whole(log: pd.DataFrame, rng: np.random.Generator) -> pd.DataFrame:
        name = str(rng.choice(log.columns))
        return log.rename(columns={name: rename(name)})

    return _table(whole)


def _replaced_by(make: Callable[[Path], None]) -> Bend:
    def bend(path: Path, rng: np.random.Generator) -> None:
        path.unlink()
        make(path)

    return bend


def _cut(data: bytes, rng: np.random.Generator) -> bytes:
    return data[: int(rng.integers(1, len(data)))]


def _late_byte(data: bytes, rng: np.random.Generator) -> bytes:
    at = int(rng.integers(len(data) // 2, len(data)))
    return data[:at] + b"\xff" + data[at:]


FILES = tuple(
    Mutation("file", name, bend, codes, harmless)
    for name, bend, codes, harmless in (
        ("empty", _bytes(lambda d, r: b""), REFUSED, False),
        ("cut at a random byte", _bytes(_cut), ANY, False),
        ("non-UTF-8 byte late in the file", _bytes(_late_byte), REFUSED, False),
        ("UTF-16", _bytes(lambda d, r: d.decode().encode("utf-16")), REFUSED, False),
        ("random bytes", _bytes(lambda d, r: r.bytes(4096)), REFUSED, False),
        ("zero bytes", _bytes(lambda d, r: bytes(4096)), REFUSED, False),
        ("folder in its place", _replaced_by(Path.mkdir), REFUSED, False),
        ("missing", _replaced_by(lambda p: None), REFUSED, False),
        ("link to itself", _replaced_by(lambda p: p.symlink_to(p)), REFUSED, False),
        ("pipe in its place", _replaced_by(os.mkfifo), REFUSED, False),
    )
)
LOGS = (
    Mutation("file", "byte order mark", _bytes(lambda d, r: b"\xef\xbb\xbf" + d), harmless=True),
    Mutation("file", "line of a million characters",
             _bytes(lambda d, r: d + b"x" * 1_000_000 + b"\n"), REFUSED),
    Mutation("file", "compressed, named .csv", _bytes(lambda d, r: gzip.compress(d)), REFUSED),
    Mutation("header", "misspelt", _renamed(lambda n: n[:-1] + "q")),
    Mutation("header", "blank", _renamed(lambda n: " ")),
    Mutation("header", "semicolons", _bytes(lambda d, r: d.replace(b",", b";"))),
    Mutation("header", "units row", _bytes(lambda d, r: d.replace(b"\n", b"\n[x],[x]\n", 1)),
             REFUSED),
    Mutation("header", "twice", _bytes(lambda d, r: d.replace(b"\n", b"\n" + d.split(b"\n")[0]
             + b"\n", 1)), REFUSED),
    Mutation("header", "columns in another order", _table(
        lambda t, r: t[list(r.permutation(t.columns))]), harmless=True),
    Mutation("value", "header only", _table(lambda t, r: t.iloc[:0]), REFUSED),
    Mutation("value", "one row", _table(lambda t, r: t.iloc[:1])),
    Mutation("value", "two rows", _table(lambda t, r: t.iloc[:2])),
    *(Mutation("value", f"a cell is {value!r}", _cell(value))
      for value in ("nan", "inf", "1e308", "-1e400", "abc", "1,5", "True", "2026-11-24 10:00",
                    "9007199254740993", "-8388608", "", "<script>alert(1)</script>")),
    Mutation("value", "a column of zeros", _column(lambda s: 0 * s)),
    Mutation("value", "a column is constant", _column(lambda s: 0 * s + s[0])),
    Mutation("value", "a column is empty", _column(lambda s: np.nan * s)),
    Mutation("value", "a column turned", _column(lambda s: -s)),
    Mutation("value", "a column of truth values", _column(lambda s: s > np.median(s))),
    Mutation("value", "a column times 1e300", _column(lambda s: s * 1e300)),
    Mutation("time", "reversed", _stamps(lambda s: s[::-1])),
    Mutation("time", "all the same", _stamps(lambda s: 0 * s)),
    Mutation("time", "in milliseconds", _stamps(lambda s: 1e3 * s)),
    Mutation("time", "nanoseconds since 1970", _stamps(lambda s: 1.7e18 + 1e9 * s)),
    Mutation("time", "shuffled rows", _table(lambda t, r: t.sample(frac=1, random_state=r))),
)  # fmt: skip
FORCES = (
    *(
        Mutation("physical", f"{unit} under the name of newtons", _scaled("_n", factor), wrong=True)
        for unit, factor in (("kg", 1 / 9.80665), ("g", 1e3 / 9.80665), ("lbf", 1 / 4.448222))
    ),
    Mutation("physical", "turned sign", _scaled("_n", -1.0), wrong=True),
)


def _text(change: Callable[[str, np.random.Generator], str]) -> Bend:
    return _bytes(lambda d, r: change(d.decode(), r).encode())


_RECIPE = (
    ("unknown key", "\n[robot2]\nx = 1\n"),
    ("misspelt canonical name", '\n[columns]\nlaod_n = "m"\n'),
    ("power tower as unit", '\n[columns]\ntime_s = { column = "time_s", unit = "s**9**9**9" }\n'),
    ("unit of another quantity", '\n[columns]\ntime_s = { column = "time_s", unit = "kg" }\n'),
    ("nested 3000 deep", "\n[data]\nweights = " + "[" * 3000 + "]" * 3000 + "\n"),
    ("wrong type", "\n[data]\nweights = true\n"),
    ("not TOML", "\n= = =\n"),
)


def _appended(tail: str) -> Bend:
    return _text(lambda t, r: t + tail)


RECIPES = (
    *(Mutation("recipe", name, _appended(tail), REFUSED) for name, tail in _RECIPE),
    Mutation("recipe", "markup in the robot's name",
             _text(lambda t, r: t.replace('name = "', 'name = "<script>alert(1)</script>', 2)),
             harmless=True),
)  # fmt: skip


def _json(change: Callable[[dict[str, Any]], None]) -> Bend:
    def text(content: str, rng: np.random.Generator) -> str:
        record = json.loads(content)
        change(record)
        return json.dumps(record)

    return _text(text)


def _each(value: object, key: str = "value") -> Bend:
    def change(record: dict[str, Any]) -> None:
        next(iter(record["parameters"].values()))[key] = value

    return _json(change)


PARAMETERS = tuple(
    Mutation("parameters", name, bend, codes)
    for name, bend, codes in (
        ("another schema", _json(lambda r: r.update(schema="footcal.run")), REFUSED),
        ("newer version", _json(lambda r: r.update(schema_version=2)), REFUSED),
        ("no parameters", _json(lambda r: r.update(parameters={})), REFUSED),
        ("value NaN", _each(float("nan")), REFUSED),
        ("value is a string", _each("1.0"), REFUSED),
        ("value is a truth value", _each(True), REFUSED),
        ("value 1e308", _each(1e308), ANY),
        ("negative sd", _each(-1.0, "sd"), REFUSED),
        ("covariance of another shape", _json(lambda r: r.update(
            covariance=[{"names": ["left_fl.scale", "left_fl.bias"], "matrix": [[1.0]]}])),
         REFUSED),
        ("nested 100000 deep", _text(lambda t, r: "[" * 100_000), REFUSED),
        ("gravity of the moon", _json(lambda r: r.update(gravity_mps2=1.62)), ANY),
    )
)  # fmt: skip
