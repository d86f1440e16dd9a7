"""JSON: one object a line or a list of objects, nested objects as dotted names."""

from __future__ import annotations

import ast
import gzip
import io
import json
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any, TextIO

import numpy as np

from footcal_cli.errors import DataError
from footcal_cli.formats.contract import CHUNK_ROWS, Arrays, ClockOf, Stream, seconds, time_column
from footcal_cli.formats.messages import flat


def streams(path: Path, _clock: ClockOf) -> tuple[Stream, ...]:
    """The one table of the file; its columns are those of any line.

    Raises
    ------
    DataError
        A line that is no JSON object, or a value that is now a number, now a text.
    """
    kinds: dict[str, str] = {}
    count = 0
    left_out: dict[str, None] = {}
    first = last = None
    for number, values, others in _objects(path):
        count += 1
        left_out |= dict.fromkeys(others)
        for name, value in values.items():
            kind = _kind(value)
            before = kinds.setdefault(name, kind)
            if "text" in {kind, before} and kind != before:
                raise DataError(
                    f"now a {before}, now a {kind}", file=path, column=name, row=f"line {number}",
                    value=value, remedy="write numbers without quotes",
                )  # fmt: skip
            if before == "whole" and kind == "number":
                kinds[name] = "number"
        if (time := time_column(tuple(kinds))) is not None and kinds[time] != "text":
            first = values.get(time) if first is None else first
            last = values.get(time, last)
    complete = _complete(path, kinds) if count else set()
    kinds = {n: "number" if k == "whole" and n not in complete else k for n, k in kinds.items()}
    time = time_column(tuple(kinds))
    time = None if time is not None and kinds[time] == "text" else time
    duration_s = None
    if time is not None and first is not None and last is not None:
        duration_s = float(seconds(np.array([first, last]), time)[-1])
    return (
        Stream(
            path.name.split(".")[0], "JSON lines", count, tuple(kinds), time,
            f"column {time}" if time else "no stamps", partial(_chunks, path, kinds),
            tuple(left_out), duration_s,
        ),
    )  # fmt: skip


def _complete(path: Path, kinds: dict[str, str]) -> set[str]:
    """Columns that every line has."""
    found = set(kinds)
    for _, values, _ in _objects(path):
        found &= values.keys()
    return found


def _chunks(path: Path, kinds: dict[str, str]) -> Iterator[Arrays]:
    rows: list[dict[str, Any]] = []
    for _, values, _ in _objects(path):
        rows.append(values)
        if len(rows) >= CHUNK_ROWS:
            yield _columns(rows, kinds)
            rows = []
    if rows:
        yield _columns(rows, kinds)


def _columns(rows: list[dict[str, Any]], kinds: dict[str, str]) -> Arrays:
    dtypes: dict[str, Any] = {"text": object, "whole": np.int64, "number": np.float64}
    absent: dict[str, Any] = {"text": "", "whole": 0, "number": np.nan}
    return {
        name: np.array([row.get(name, absent[kind]) for row in rows], dtype=dtypes[kind])
        for name, kind in kinds.items()
    }


def _kind(value: object) -> str:
    if isinstance(value, str):
        return "text"
    return "whole" if isinstance(value, int) else "number"


def _each(stream: TextIO) -> Iterator[str]:
    """Lines, or the objects of a document that is one list, as a line each."""
    first = stream.readline()
    rest = stream.read() if first.lstrip().startswith("[") or not _is_object(first) else ""
    if rest or not (second := stream.readline()):
        samples = _samples(_document(first + rest))
        if samples is not None:
            yield from map(json.dumps, samples)
            return
        yield first
        yield from io.StringIO(rest)  # refused as the lines that they are
        return
    yield first
    yield second
    yield from stream


def _is_object(line: str) -> bool:
    try:
        return isinstance(json.loads(line), dict)
    except json.JSONDecodeError:
        return False


def _samples(document: Any) -> list[Any] | None:
    """The samples of one document: a list, the list of objects in it, or lists of one length."""
    if isinstance(document, list):
        return _unfolded(document)
    if not isinstance(document, dict):
        return None
    lists = {name: value for name, value in document.items() if isinstance(value, list)}
    objects = [v for v in lists.values() if len(v) > 1 and all(isinstance(x, dict) for x in v)]
    if len(objects) == 1:
        return _unfolded(objects[0])
    if len(objects) > 1 and len({len(own) for own in objects}) > 1:
        named = {name: own for name, own in lists.items() if own in objects}
        return [{"channel": name, **one} for name, own in named.items() for one in own]
    lengths = {len(value) for value in lists.values()}
    if len(lists) > 1 and len(lengths) == 1 and min(lengths) > 3:
        rows = zip(*lists.values(), strict=True)
        return [dict(zip(lists, row, strict=True)) for row in rows]
    inner = [value for value in document.values() if isinstance(value, dict)]
    found = [samples for one in inner if (samples := _samples(one)) is not None]
    return found[0] if len(found) == 1 else None


def _unfolded(objects: list[Any]) -> list[Any]:
    """Objects with a list of objects in each, as a row for each of these beside what is above it.

    A calibration of several channels: each with its weights and what they gave.
    """
    inner = {
        name for one in objects if isinstance(one, dict) for name, value in one.items()
        if isinstance(value, list) and value and all(isinstance(x, dict) for x in value)
    }  # fmt: skip
    if len(inner) != 1 or not all(isinstance(one, dict) and inner <= one.keys() for one in objects):
        return objects
    name = inner.pop()
    rows = [
        {**{k: v for k, v in one.items() if k != name}, **own}
        for one in objects
        for own in one[name]
    ]
    return _unfolded(rows)


def _document(text: str) -> Any:
    """What a document says, in JSON or as Python prints it; None where it is neither."""
    for read in (json.loads, ast.literal_eval):
        try:
            return read(text)
        except (ValueError, SyntaxError, MemoryError, RecursionError):
            pass
    return None


def _objects(path: Path) -> Iterator[tuple[int, dict[str, Any], list[str]]]:
    opener = gzip.open if path.suffix == ".gz" else open
    try:
        with opener(path, "rt", encoding="utf-8-sig") as stream:
            for number, line in enumerate(_each(stream), start=1):
                if not line.strip():
                    continue
                try:
                    content = json.loads(line)
                except json.JSONDecodeError as error:
                    raise DataError(
                        f"not valid JSON (truncated?): {error.msg}", file=path,
                        row=f"line {number}", remedy="delete or complete the line",
                    ) from None  # fmt: skip
                if not isinstance(content, dict):
                    raise DataError(
                        "not a JSON object", file=path, row=f"line {number}",
                        remedy='write one object a line: {"time_s": 0.0, …}',
                    )  # fmt: skip
                yield number, *flat(content)
    except (UnicodeDecodeError, EOFError, OSError):
        raise DataError("not readable as UTF-8 text", file=path, remedy="export it again") from None
