"""Logs as other tools write them: bags, MCAP, MATLAB, HDF5, JSON lines and text."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pandas as pd
from mcap.writer import Writer as McapWriter
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as Writer2
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from scipy.io import savemat

Frames = Mapping[str, pd.DataFrame]
"""Logs by topic; each has ``time_ns`` and numbers."""


def definition(frame: pd.DataFrame) -> str:
    """A message of the frame's columns under a header, as a robot's own package has one."""
    kinds = {"i": "int32", "f": "float64"}
    fields = [
        f"{kinds[dtype.kind]} {name}" for name, dtype in frame.dtypes.items() if name != "time_ns"
    ]
    return "\n".join(["std_msgs/Header header", *fields])


def _messages(frames: Frames, store: Any, header: Callable[[int], Any]) -> Any:
    """Topic, type name and message of every row, all topics mixed by time."""
    rows: list[tuple[int, str, str, Any]] = []
    for topic, frame in frames.items():
        name = f"walker_msgs/msg/{topic.capitalize()}"
        store.register(get_types_from_msg(definition(frame), name))
        made = store.types[name]
        fields = [c for c in frame if c != "time_ns"]
        for stamp, *values in zip(frame["time_ns"], *(frame[c] for c in fields), strict=True):
            content = dict(
                zip(
                    map(str, fields),
                    (v.item() if hasattr(v, "item") else v for v in values),
                    strict=True,
                )
            )
            rows.append((int(stamp), topic, name, made(header=header(int(stamp)), **content)))
    return sorted(rows, key=lambda row: row[0])


def write_ros1(path: Path, frames: Frames, late_ns: int = 0) -> Path:
    """A ROS 1 bag recorded `late_ns` after the header stamps."""
    store = get_typestore(Stores.ROS1_NOETIC)
    header, time = store.types["std_msgs/msg/Header"], store.types["builtin_interfaces/msg/Time"]
    rows = _messages(frames, store, lambda ns: header(0, time(ns // 10**9, ns % 10**9), "base"))
    with Writer1(path) as bag:
        links = {}
        for ns, topic, name, message in rows:
            if topic not in links:
                links[topic] = bag.add_connection(f"/{topic}", name, typestore=store)
            raw = store.serialize_ros1(message, name)
            bag.write(links[topic], ns + late_ns, raw)
    return path


def write_ros2(
    path: Path, frames: Frames, late_ns: int = 0, storage: StoragePlugin = StoragePlugin.SQLITE3
) -> Path:
    """A ROS 2 bag recorded `late_ns` after the header stamps."""
    store = get_typestore(Stores.ROS2_HUMBLE)
    header, time = store.types["std_msgs/msg/Header"], store.types["builtin_interfaces/msg/Time"]
    rows = _messages(frames, store, lambda ns: header(time(ns // 10**9, ns % 10**9), "base"))
    with Writer2(path, version=9, storage_plugin=storage) as bag:
        links = {}
        for ns, topic, name, message in rows:
            if topic not in links:
                links[topic] = bag.add_connection(f"/{topic}", name, typestore=store)
            bag.write(links[topic], ns + late_ns, store.serialize_cdr(message, name))
    return path


def write_mcap(path: Path, frames: Frames) -> Path:
    """An MCAP file of JSON messages, as loggers without ROS write it."""
    with path.open("wb") as stream:
        writer = McapWriter(stream)
        writer.start()
        for topic, frame in frames.items():
            schema = writer.register_schema(topic, "jsonschema", b'{"type": "object"}')
            channel = writer.register_channel(f"/{topic}", "json", schema)
            for row in frame.to_dict("records"):
                ns = int(row.pop("time_ns"))
                content = {
                    "header": {"stamp": {"sec": ns // 10**9, "nanosec": ns % 10**9}}, **row
                }  # fmt: skip
                writer.add_message(channel, ns, json.dumps(content).encode(), ns)
        writer.finish()  # type: ignore[no-untyped-call] # mcap types all but this
    return path


def _plain(frame: pd.DataFrame) -> dict[str, np.ndarray[Any, Any]]:
    return {str(name): frame[name].to_numpy() for name in frame}


def write_mat(path: Path, frames: Frames) -> Path:
    """A MATLAB file up to version 7: a struct per topic, column vectors."""
    columns = {t: {n: v[:, None] for n, v in _plain(f).items()} for t, f in frames.items()}
    savemat(path, columns, do_compression=True)
    return path


def write_mat73(path: Path, frames: Frames) -> Path:
    """The same as version 7.3: HDF5 behind a 512-byte block, axes reversed."""
    with h5py.File(path, "w", userblock_size=512) as file:
        for topic, frame in frames.items():
            for name, values in _plain(frame).items():
                made = file.create_dataset(f"{topic}/{name}", data=values[None, :])
                made.attrs["MATLAB_class"] = np.bytes_("double")
    with path.open("r+b") as stream:
        stream.write(b"MATLAB 7.3 MAT-file".ljust(124) + b"\x00\x02IM")
    return path


def write_hdf5(path: Path, frames: Frames) -> Path:
    """A group per topic."""
    with h5py.File(path, "w") as file:
        for topic, frame in frames.items():
            for name, values in _plain(frame).items():
                file[f"{topic}/{name}"] = values
    return path


def write_lines(path: Path, frame: pd.DataFrame) -> Path:
    """One JSON object a line."""
    rows = (json.dumps(row) for row in frame.to_dict("records"))
    path.write_text("\n".join(rows) + "\n", encoding="utf-8")
    return path


def write_c3d(path: Path) -> Path:
    """Two analog channels at 200 Hz and a marker at 100 Hz, moments in Nmm."""
    import ezc3d

    made = ezc3d.c3d()
    made["parameters"]["POINT"]["RATE"]["value"] = [100.0]
    made["parameters"]["POINT"]["LABELS"]["value"] = ("heel",)
    made["parameters"]["POINT"]["UNITS"]["value"] = ("mm",)
    made["parameters"]["ANALOG"]["RATE"]["value"] = [200.0]
    made["parameters"]["ANALOG"]["LABELS"]["value"] = ("Fz1", "Mx1")
    made.add_parameter("ANALOG", "UNITS", ["N", "Nmm"])
    made["data"]["points"] = np.array([10.0, 20.0, 30.0, 1.0])[:, None, None] * np.ones((4, 1, 3))
    made["data"]["analogs"] = np.array([[np.arange(6.0), 100.0 * np.arange(6.0)]])
    made.write(str(path))
    return path
