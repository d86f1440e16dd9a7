"""ROS 1 bags and ROS 2 bags (sqlite3 and MCAP storage), read by rosbags without ROS."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

from footcal_cli.errors import DataError, FootcalError
from footcal_cli.formats.contract import Arrays, ClockOf, Stream, library
from footcal_cli.formats.messages import Shape, TopicRows


def streams(path: Path, clock: ClockOf) -> tuple[Stream, ...]:
    """All topics of a bag: a ``.bag`` or ``.db3`` file, or the folder of a ROS 2 bag.

    Raises
    ------
    UsageError
        rosbags is not installed.
    DataError
        Truncated or damaged.
    """
    with _opened(path) as reader:
        # one topic may have several connections (writers)
        counts: dict[str, int] = {}
        kinds: dict[str, str] = {}
        for connection in reader.connections:
            counts[connection.topic] = counts.get(connection.topic, 0) + connection.msgcount
            kinds[connection.topic] = connection.msgtype
        shapes = _shapes(reader, {topic for topic, count in counts.items() if count})
        duration_s = reader.duration * 1e-9
    return tuple(
        _stream(path, clock, topic, kinds[topic], counts[topic], shapes.get(topic), duration_s)
        for topic in sorted(counts)
    )


def _stream(
    path: Path, clock: ClockOf, topic: str, kind: str, rows: int, shape: Shape | str | None,
    duration_s: float,
) -> Stream:  # fmt: skip
    if not isinstance(shape, Shape):
        reason = (shape,) if shape else ()
        return Stream(topic, kind, rows, (), None, "", lambda: iter(()), reason, duration_s)
    return Stream(
        topic, kind, rows, ("time_ns", *shape.columns) if shape.columns else (), "time_ns",
        shape.clock(clock), partial(_chunks, path, topic, shape, clock), shape.left_out, duration_s,
    )  # fmt: skip


def _shapes(reader: Any, wanted: set[str]) -> dict[str, Shape | str]:
    """The shape of each topic's first message, or why it cannot be read."""
    found: dict[str, Shape | str] = {}
    for connection, _, raw in reader.messages():
        if connection.topic in found:
            continue
        try:
            found[connection.topic] = Shape.of(reader.deserialize(raw, connection.msgtype))
        except KeyError:
            found[connection.topic] = f"the bag does not define {connection.msgtype}"
        if len(found) == len(wanted):
            break
    return found


def _chunks(path: Path, topic: str, shape: Shape, clock: ClockOf) -> Iterator[Arrays]:
    rows = TopicRows(shape, clock, path, topic)
    with _opened(path) as reader:
        mine = [connection for connection in reader.connections if connection.topic == topic]
        for connection, log_ns, raw in reader.messages(connections=mine):
            rows.add(reader.deserialize(raw, connection.msgtype), log_ns)
            if rows.full:
                yield rows.take()
    if len(rows):
        yield rows.take()


class _opened:  # noqa: N801 - used as a function
    """The bag as a context; whatever rosbags stumbles over is one line."""

    def __init__(self, path: Path) -> None:
        highlevel = library("rosbags.highlevel", "ros", "a ROS bag")
        typesys = library("rosbags.typesys", "ros", "a ROS bag")
        self.path = path
        # a ROS 2 bag with sqlite3 storage before Iron carries no message definitions
        store = typesys.get_typestore(typesys.Stores.ROS2_HUMBLE)
        try:
            self.reader = highlevel.AnyReader([path], default_typestore=store)
        except Exception as error:
            raise self._damaged(error) from None

    def __enter__(self) -> Any:
        try:
            self.reader.open()
        except Exception as error:
            raise self._damaged(error) from None
        return self.reader

    def __exit__(self, kind: object, error: BaseException | None, trace: object) -> None:
        self.reader.close()
        if isinstance(error, Exception) and not isinstance(error, FootcalError):
            raise self._damaged(error) from None

    def _damaged(self, error: Exception) -> DataError:
        first = (str(error) or type(error).__name__).splitlines()[0]
        return DataError(
            f"not a readable ROS bag (truncated?): {first}", file=self.path,
            remedy="copy it again; a ROS 1 bag whose recording broke off needs rosbag reindex, a "
            "ROS 2 bag ros2 bag reindex",
        )  # fmt: skip
