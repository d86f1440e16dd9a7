"""OpenSim's ``.mot`` and ``.sto``: a header up to ``endheader``, one line of names, a table.

Format: https://opensimconfluence.atlassian.net/wiki/spaces/OpenSim/pages/53089417/Storage+.sto+Files
Names of ground reactions (``ground_force_vx``, ``_px``, ``ground_torque_x``) are in N, m and Nm;
``inDegrees`` says the unit of rotational coordinates in a motion.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from footcal_cli.errors import DataError
from footcal_cli.formats.arrays import stream_of
from footcal_cli.formats.contract import Arrays, ClockOf, Stream

_GROUND = ((r"_v[xyz]$", "n"), (r"_p[xyz]$", "m"), (r"(torque|moment|_m)_?[xyz]$", "nm"))
_TRANSLATION = re.compile(r"_t[xyz]$")


def streams(path: Path, _clock: ClockOf) -> tuple[Stream, ...]:
    """The one table of the file.

    Raises
    ------
    DataError
        No header, a broken row, or fewer rows than the header promises.
    """
    header, names, body, first_line = _split(path)
    rows = _rows(body, len(names), path, first_line)
    promised = header.get("nrows", header.get("datarows", ""))
    if promised.isdigit() and int(promised) != len(rows):
        raise DataError(
            f"the header promises {promised} rows, the file has {len(rows)} (truncated?)",
            file=path, remedy="copy or export it again",
        )  # fmt: skip
    in_degrees = header.get("indegrees", "")
    columns: Arrays = {
        _with_unit(name, names, in_degrees): rows[:, i] for i, name in enumerate(names)
    }
    return (stream_of(path.stem, "OpenSim storage", columns),)


def _split(path: Path) -> tuple[dict[str, str], list[str], list[str], int]:
    """Header, column names, lines of data and the number of the first of them."""
    try:
        lines = path.read_text(encoding="utf-8-sig").splitlines()
    except UnicodeDecodeError:
        raise DataError("not a text file", file=path, remedy="export it again") from None
    ends = [i for i, line in enumerate(lines) if line.strip().lower() == "endheader"]
    if not ends or len(lines) < ends[0] + 2:
        raise DataError(
            "no 'endheader' line with column names after it", file=path,
            remedy="export it again from OpenSim",
        )  # fmt: skip
    header = {}
    for line in lines[: ends[0]]:
        key, found, value = line.partition("=")
        if found:
            header[key.strip().lower()] = value.strip().lower()
    names = lines[ends[0] + 1].split("\t" if "\t" in lines[ends[0] + 1] else None)
    return (
        header,
        [name.strip() for name in names if name.strip()],
        lines[ends[0] + 2 :],
        ends[0] + 3,
    )


def _rows(body: list[str], width: int, path: Path, first_line: int) -> np.ndarray[
    tuple[int, int], np.dtype[np.float64]
]:  # fmt: skip
    rows = []
    for number, line in enumerate(body, start=first_line):
        fields = line.split()
        if not fields:
            continue
        if len(fields) != width:
            raise DataError(
                f"{len(fields)} fields under {width} names", file=path, row=f"line {number}",
                remedy="copy or export it again",
            )  # fmt: skip
        try:
            rows.append([float(field) for field in fields])
        except ValueError:
            raise DataError(
                "not a number", file=path, row=f"line {number}",
                value=next(f for f in fields if not _is_number(f)), remedy="correct the cell",
            ) from None  # fmt: skip
    return np.array(rows, dtype=np.float64).reshape(len(rows), width)


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _with_unit(name: str, names: list[str], in_degrees: str) -> str:
    lower = name.lower()
    if lower == "time":
        return "time_s"
    if "force" in lower or "torque" in lower or "grf" in lower:
        for pattern, suffix in _GROUND:
            if re.search(pattern, lower):
                return f"{name}_{suffix}"
        return name
    if in_degrees not in {"yes", "no"} or any("force" in other.lower() for other in names):
        return name
    angle = "deg" if in_degrees == "yes" else "rad"
    if lower.endswith(("/speed", "_u")):
        return name
    stem = lower.removesuffix("/value")
    return f"{name}_m" if _TRANSLATION.search(stem) else f"{name}_{angle}"
