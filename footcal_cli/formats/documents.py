"""Messages as `rostopic echo`, `ros2 topic echo` and `gz topic -e` print them: indented keys."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from footcal_cli.errors import DataError
from footcal_cli.formats.arrays import stream_of
from footcal_cli.formats.contract import Array, Arrays, ClockOf, Stream, number_of
from footcal_cli.tables.foreign import without_braces

_ENTRY = re.compile(r"^(?P<indent>\s*)(?P<dash>- )?(?:(?P<key>[A-Za-z_][\w ]*):)?\s*(?P<value>.*)$")
_LIST = re.compile(r"^\[(.*)\]$")


def streams(path: Path, _clock: ClockOf) -> tuple[Stream, ...]:
    """The one table of the messages: a column for every number, keys joined by dots.

    Raises
    ------
    DataError
        No message with a number.
    """
    text = without_braces(path.read_text(encoding="utf-8-sig", errors="replace"))
    messages = [dict(_values(part)) for part in re.split(r"(?m)^---\s*$", text) if part.strip()]
    if messages and messages[-1].keys() != messages[0].keys():
        messages.pop()  # the recording was ended within it
    if not messages or not messages[0]:
        raise DataError("no message with a number", file=path, remedy="record the topic again")
    names = list(messages[0])
    for number, message in enumerate(messages, start=1):
        if list(message) != names:
            odd = next(iter(set(names) ^ set(message)))
            raise DataError(
                f"'{odd}' does not stand in every message", file=path, row=f"message {number}",
                remedy="record one topic of one type, with lists of one length",
            )  # fmt: skip
    columns = {name: np.array([message[name] for message in messages]) for name in names}
    return (stream_of(path.stem, "messages as text", _stamped(columns)),)


def _stamped(columns: Arrays) -> Arrays:
    """The stamp of a header as whole nanoseconds."""
    for seconds, rest in (("sec", "nanosec"), ("secs", "nsecs")):
        names = next(
            ((name, other) for name in columns if name.endswith(f"stamp.{seconds}")
             and (other := f"{name.removesuffix(seconds)}{rest}") in columns), None,
        )  # fmt: skip
        if names is not None:
            whole, nanoseconds = (columns.pop(name) for name in names)
            stamp: Array = whole.astype(np.int64) * 10**9 + nanoseconds.astype(np.int64)
            return {"time_ns": stamp, **columns}
    return columns


def _values(message: str) -> Iterator[tuple[str, Any]]:
    """Numbers of one message by dotted names; texts are left out."""
    above: list[tuple[int, str]] = []
    counts: dict[str, int] = {}
    for line in message.splitlines():
        found = _ENTRY.match(line)
        if found is None or not line.strip():
            continue
        indent = len(found["indent"])
        while above and (above[-1][0] > indent or (above[-1][0] == indent and not found["dash"])):
            above.pop()
        name = ".".join([key for _, key in above] + [found["key"] or ""]).strip(".")
        if found["dash"]:
            counts[name] = counts.get(name, -1) + 1
            name = f"{name}_{counts[name]}"
        value = found["value"].strip()
        if found["key"] and not value:
            above.append((indent, found["key"]))
        elif (several := _LIST.match(value)) is not None:
            for i, word in enumerate(several[1].split(",")):
                if (number := number_of(word)) is not None:
                    yield f"{name}_{i}", number
        elif (number := number_of(value)) is not None:
            yield name, number
