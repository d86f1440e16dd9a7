"""MCAP files: ROS 1, ROS 2 and JSON messages, read by mcap; ROS types are decoded by rosbags."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

from footcal_cli.errors import DataError, FootcalError
from footcal_cli.formats.contract import Arrays, ClockOf, Stream, library
from footcal_cli.formats.messages import Shape, TopicRows

Decode = Callable[[bytes], object]


def streams(path: Path, clock: ClockOf) -> tuple[Stream, ...]:
    """All topics of an MCAP file.

    Raises
    ------
    UsageError
        mcap or rosbags is not installed.
    DataError
        Truncated or damaged.
    """
    counts: dict[str, int] = {}
    kinds: dict[str, str] = {}
    shapes: dict[str, Shape | str] = {}
    spans: dict[str, tuple[int, int]] = {}
    decoders: dict[int, Decode | str] = {}
    for schema, channel, message in _messages(path, None):
        topic = channel.topic
        counts[topic] = counts.get(topic, 0) + 1
        first, _ = spans.get(topic, (message.log_time, 0))
        spans[topic] = (first, message.log_time)
        if topic in shapes:
            continue
        kinds[topic] = schema.name if schema is not None else channel.message_encoding
        decode = decoders.setdefault(channel.id, _decoder(schema, channel))
        shapes[topic] = decode if isinstance(decode, str) else Shape.of(decode(message.data))
    found = []
    for topic in sorted(counts):
        shape, (first, last) = shapes[topic], spans[topic]
        duration_s = (last - first) * 1e-9
        if isinstance(shape, str):
            found.append(
                Stream(topic, kinds[topic], counts[topic], (), None, "", lambda: iter(()),
                       (shape,), duration_s)
            )  # fmt: skip
            continue
        found.append(
            Stream(
                topic, kinds[topic], counts[topic],
                ("time_ns", *shape.columns) if shape.columns else (), "time_ns",
                shape.clock(clock), partial(_chunks, path, topic, shape, clock), shape.left_out,
                duration_s,
            )
        )  # fmt: skip
    return tuple(found)


def _chunks(path: Path, topic: str, shape: Shape, clock: ClockOf) -> Iterator[Arrays]:
    rows = TopicRows(shape, clock, path, topic)
    decoders: dict[int, Decode | str] = {}
    for schema, channel, message in _messages(path, topic):
        if channel.id not in decoders:
            decoders[channel.id] = _decoder(schema, channel)
        decode = decoders[channel.id]
        if isinstance(decode, str):
            raise DataError(decode, file=path, row=f"topic {topic}")
        rows.add(decode(message.data), message.log_time)
        if rows.full:
            yield rows.take()
    if len(rows):
        yield rows.take()


def _messages(path: Path, topic: str | None) -> Iterator[tuple[Any, Any, Any]]:
    """Schema, channel and message one by one; what mcap stumbles over is one line."""
    reader = library("mcap.reader", "mcap", "an MCAP file")
    try:
        with path.open("rb") as stream:
            opened = reader.make_reader(stream)
            yield from opened.iter_messages(topics=None if topic is None else [topic])
    except FootcalError:
        raise
    except Exception as error:
        first = (str(error) or type(error).__name__).splitlines()[0]
        raise DataError(
            f"not a readable MCAP file (truncated?): {first}", file=path,
            remedy="copy it again, or repair it with: mcap recover",
        ) from None  # fmt: skip


def _decoder(schema: Any, channel: Any) -> Decode | str:
    """How to read a channel's messages, or why they cannot be read."""
    if channel.message_encoding == "json":
        return json.loads
    ros = {"cdr": "ros2msg", "ros1": "ros1msg"}
    if schema is None or ros.get(channel.message_encoding) != schema.encoding:
        what = schema.encoding if schema is not None else "no schema"
        return f"{channel.message_encoding} messages with {what} are not read"
    typesys = library("rosbags.typesys", "mcap", "an MCAP file of ROS messages")
    store = typesys.get_typestore(typesys.Stores.EMPTY)
    name = schema.name if "/msg/" in schema.name else schema.name.replace("/", "/msg/", 1)
    types = typesys.get_types_from_msg(schema.data.decode(), name)
    known = set(store.fielddefs)
    store.register({key: value for key, value in types.items() if key not in known})
    read = store.deserialize_cdr if channel.message_encoding == "cdr" else store.deserialize_ros1
    return partial(_deserialized, read, name)


def _deserialized(read: Callable[[bytes, str], object], name: str, raw: bytes) -> object:
    return read(raw, name)
