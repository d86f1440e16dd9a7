"""Messages of any type as rows of columns: nested fields flattened, units of standard messages.

Units are those of REP 103 and of the comments in the message definitions
(https://www.ros.org/reps/rep-0103.html, https://docs.ros.org/en/rolling/p/geometry_msgs).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields, is_dataclass
from pathlib import Path
from typing import Any

import numpy as np

from footcal_cli.errors import DataError
from footcal_cli.formats.contract import CHUNK_ROWS, Arrays, ClockOf, component_names

_SUFFIX: Mapping[tuple[str, str], str] = {
    ("Wrench", "force"): "n", ("Wrench", "torque"): "nm",
    ("Pose", "position"): "m", ("Transform", "translation"): "m", ("PointStamped", "point"): "m",
    ("Twist", "linear"): "mps", ("Twist", "angular"): "radps",
    ("Accel", "linear"): "mps2", ("Accel", "angular"): "radps2",
    ("Imu", "angular_velocity"): "radps", ("Imu", "linear_acceleration"): "mps2",
    ("Temperature", "temperature"): "degc", ("FluidPressure", "fluid_pressure"): "pa",
}  # fmt: skip
"""Message type and field -> unit suffix of all numbers below it."""

_NOT_NUMBERS = {"header", "layout", "child_frame_id", "structure_needs_at_least_one_member"}
_EXACT_IN_DOUBLE = 2**53
_BY_NAME = ("position", "velocity", "effort")
_CALLED = ("name", "leg", "foot", "side", "cell", "channel", "sensor", "id")
"""What an object in a list says to be called."""
_MOST_PARTS = 12
_ROWS = (3, 4)
"""Rows of a rotation, and of a pose."""


def flat(message: object) -> tuple[dict[str, Any], list[str]]:
    """Numbers and texts of a message by dotted name, and what cannot be a column.

    Parameters
    ----------
    message
        A dataclass (ROS) or a mapping (JSON).

    Returns
    -------
    values, left_out
        Left out are covariances, lists of messages and empty lists.
    """
    values: dict[str, Any] = {}
    left_out: list[str] = []
    if _short_type(message) == "JointState":
        _joints(message, values)
        return values, left_out
    _walk(message, "", "", values, left_out)
    return values, left_out


def _short_type(message: object) -> str:
    return str(getattr(message, "__msgtype__", "")).rsplit("/", 1)[-1]


def _items(message: object) -> Iterator[tuple[str, Any]]:
    if isinstance(message, Mapping):
        yield from ((str(key), value) for key, value in message.items())
    elif is_dataclass(message):
        for item in fields(message):
            if not item.name.startswith("__"):
                yield item.name, getattr(message, item.name)


def _walk(
    message: object, prefix: str, suffix: str, values: dict[str, Any], left_out: list[str]
) -> None:
    kind = _short_type(message)
    for name, value in _items(message):
        full = f"{prefix}{name}"
        unit = _SUFFIX.get((kind, name), suffix)
        end = f"_{unit}" if unit else ""
        if name in _NOT_NUMBERS:
            continue
        if "covariance" in name:
            left_out.append(f"{full} (covariance)")
        elif isinstance(value, Mapping) or is_dataclass(value):
            _walk(value, f"{full}.", unit, values, left_out)
        elif isinstance(value, (bool, int, float, str, np.number)):
            values[full + end] = value
        elif _are_parts(value):
            for label, part in _labelled(value):
                _walk(part, f"{full}.{label}.", unit, values, left_out)
        elif isinstance(value, (Sequence, np.ndarray)):
            value = _row_by_row(value)
            if len(value) == 0 or not isinstance(value[0], (bool, int, float, np.number)):
                left_out.append(f"{full} (empty, or no list of numbers)")
                continue
            names = (component_names(full, len(value)) if not end
                     else [f"{full}_{i}{end}" for i in range(len(value))])  # fmt: skip
            values |= dict(zip(names, value, strict=True))
        elif value is not None:
            left_out.append(f"{full} ({type(value).__name__})")


def _are_parts(value: object) -> bool:
    """Whether a value is a short list of mappings: the legs, feet or cells of one sample."""
    if not isinstance(value, list) or not 0 < len(value) <= _MOST_PARTS:
        return False
    return all(isinstance(part, Mapping) for part in value)


def _labelled(parts: Sequence[Mapping[str, Any]]) -> list[tuple[str, Mapping[str, Any]]]:
    """Parts with what they are called, or with their number where nothing calls each otherwise."""
    for key in _CALLED:
        labels = [str(part.get(key, "")) for part in parts]
        if all(labels) and len({*labels}) == len(labels):
            bare = [{k: v for k, v in part.items() if k != key} for part in parts]
            return list(zip(labels, bare, strict=True))
    return [(str(i), part) for i, part in enumerate(parts)]


def _row_by_row(
    value: Sequence[Any] | np.ndarray[Any, Any],
) -> Sequence[Any] | np.ndarray[Any, Any]:
    """A small matrix, lists of one length in a list, as its numbers row by row."""
    rows = [row for row in value if isinstance(row, list)]
    matrix = len(rows) == len(value) in _ROWS and len({len(row) for row in rows}) == 1
    return [number for row in rows for number in row] if matrix else value


def _joints(message: object, values: dict[str, Any]) -> None:
    """One column per joint and quantity: ``position.left_knee`` (rad or m, as the joint is)."""
    names = getattr(message, "name", ())
    for quantity in _BY_NAME:
        for joint, value in zip(names, getattr(message, quantity), strict=False):
            values[f"{quantity}.{joint}"] = value


def header_ns(message: object) -> int | None:
    """The header's stamp in ns, None without a header."""
    header = message.get("header") if isinstance(message, Mapping) else None
    header = header if header is not None else getattr(message, "header", None)
    stamp = header.get("stamp") if isinstance(header, Mapping) else getattr(header, "stamp", None)
    if stamp is None:
        return None
    part = (
        stamp.get
        if isinstance(stamp, Mapping)
        else lambda name, other=None: getattr(stamp, name, other)
    )
    sec = part("sec", part("secs", 0))
    nanosec = part("nanosec", part("nsec", part("nsecs", 0)))
    return int(sec) * 1_000_000_000 + int(nanosec)


@dataclass(frozen=True)
class Shape:
    """The columns that one topic's messages have, taken from its first message."""

    columns: tuple[str, ...]
    texts: frozenset[str]
    whole: frozenset[str]
    left_out: tuple[str, ...]
    stamped: bool

    @classmethod
    def of(cls, message: object) -> Shape:
        """The shape of a message."""
        values, left_out = flat(message)
        # JSON writes 2.0 as 2: of untyped numbers only those that no double holds are whole
        least = _EXACT_IN_DOUBLE if isinstance(message, Mapping) else 0
        whole = {
            name for name, value in values.items()
            if isinstance(value, (bool, np.bool_, int, np.integer)) and abs(int(value)) >= least
        }  # fmt: skip
        return cls(
            tuple(values),
            frozenset(name for name, value in values.items() if isinstance(value, str)),
            frozenset(whole),
            tuple(left_out),
            header_ns(message) is not None,
        )

    def clock(self, asked: ClockOf) -> str:
        """Which stamps the stream gets, in words."""
        if asked == "log":
            return "log time"
        return "header time" if self.stamped else "log time (no header stamps)"


@dataclass
class TopicRows:
    """Messages of one topic, gathered into pieces of columns.

    Parameters
    ----------
    shape
        Columns of the topic.
    clock
        Stamps to take where messages have both.
    path, topic
        For error messages.
    """

    shape: Shape
    clock: ClockOf
    path: Path
    topic: str
    _rows: dict[str, list[Any]] = field(default_factory=dict)
    _stamps: list[int] = field(default_factory=list)
    _zero: bool = False

    def add(self, message: object, log_ns: int) -> None:
        """One message; a joint or array element that the first message lacked is refused."""
        values, _ = flat(message)
        strange = values.keys() - set(self.shape.columns)
        if strange:
            raise DataError(
                f"{self.topic} gets more columns on the way: {min(strange)} is not in its first "
                "message", file=self.path, row=f"log time {log_ns} ns",
                remedy="convert the part before and the part after separately",
            )  # fmt: skip
        stamp = header_ns(message) if self.clock == "header" and self.shape.stamped else log_ns
        # a clock may begin at zero, once
        if stamp is None or (stamp == 0 and self._zero):
            raise DataError(
                f"{self.topic} has messages whose header stamp was never set", file=self.path,
                row=f"log time {log_ns} ns", remedy="--time log",
            )  # fmt: skip
        self._zero = self._zero or stamp == 0
        self._stamps.append(stamp)
        for name in self.shape.columns:
            absent = "" if name in self.shape.texts else np.nan
            self._rows.setdefault(name, []).append(values.get(name, absent))

    @property
    def full(self) -> bool:
        """Whether a piece is complete."""
        return len(self._stamps) >= CHUNK_ROWS

    def take(self) -> Arrays:
        """The piece gathered so far; begins the next one."""
        columns: Arrays = {"time_ns": np.array(self._stamps, dtype=np.int64)}
        for name in self.shape.columns:
            values = self._rows[name]
            if name in self.shape.texts:
                columns[name] = np.array(values, dtype=object)
            elif name in self.shape.whole:
                numbers = np.array(values)
                if numbers.dtype.kind == "f":
                    raise DataError(
                        f"{self.topic}.{name} is missing in some messages", file=self.path,
                        remedy="convert the part before and the part after separately",
                    )  # fmt: skip
                columns[name] = numbers.astype(np.int64)
            else:
                columns[name] = np.array(values, dtype=np.float64)
        self._rows, self._stamps = {}, []
        return columns

    def __len__(self) -> int:
        return len(self._stamps)
