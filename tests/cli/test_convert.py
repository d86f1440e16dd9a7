"""``footcal convert``: what other tools recorded, number by number."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from mcap.writer import Writer as McapWriter
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as Writer2
from rosbags.typesys import Stores, get_typestore

from footcal_cli.app import main
from tests.cli import foreign_logs as foreign
from tests.conftest import Run

ROOT = Path(__file__).resolve().parent.parent.parent
RECIPE = ROOT / "recipes/nao_walk.toml"
EPOCH_NS = 1_700_000_000_000_000_000
LATE_NS = 3_000_000


def footcal(*arguments: str | Path) -> None:
    """Run a command that has to succeed."""
    code: object = 0
    try:
        main([str(argument) for argument in arguments])
    except SystemExit as end:
        code = end.code
    assert not code, f"exit code {code}"


# ------------------------------------------------------------------ one walk, nine kinds of file
@pytest.fixture(scope="module")
def frames() -> dict[str, pd.DataFrame]:
    """Four seconds of a simulated walk; stamps in whole nanoseconds."""
    found = {}
    for topic in ("cells", "body"):
        frame = pd.read_parquet(ROOT / f"sample_data/biped/walk_004_{topic}.parquet")
        frame = frame[frame["time_s"] < 4.0].reset_index(drop=True)
        stamps = (frame.pop("time_s") * 1e9).round().astype("int64")
        frame = frame.astype({c: "float64" for c in frame if frame[c].dtype == "float32"})
        frame.insert(0, "time_ns", stamps)
        found[topic] = frame
    return found


def replayed(logs: list[Path], out: Path) -> dict[str, float]:
    footcal("online-replay", *logs, "--recipe", RECIPE, "--out", out, "--quiet")
    content = json.loads((out / "parameters.json").read_text())
    return {name: row["value"] for name, row in content["parameters"].items()}


@pytest.fixture(scope="module")
def wanted(
    frames: dict[str, pd.DataFrame], tmp_path_factory: pytest.TempPathFactory
) -> dict[str, float]:
    """What the walk gives as Parquet that no converter has touched."""
    folder = tmp_path_factory.mktemp("direct")
    logs = []
    for topic, frame in frames.items():
        logs.append(folder / f"{topic}.parquet")
        frame.to_parquet(logs[-1], index=False)
    return replayed(logs, folder / "out")


def as_text(write: Callable[[Path, pd.DataFrame], object], ending: str) -> Any:
    def both(folder: Path, frames: foreign.Frames) -> list[Path]:
        for topic, frame in frames.items():
            write(folder / f"{topic}{ending}", frame)
        return [folder / f"{topic}{ending}" for topic in frames]

    return both


def converted(kind: str, frames: foreign.Frames, folder: Path) -> list[Path]:
    """A walk written as one kind of file and converted; a log per topic."""
    (folder / "raw").mkdir()
    footcal("convert", *KINDS[kind](folder / "raw", frames), "--out", folder / "logs", "--quiet")
    return [folder / "logs" / f"{topic}.parquet" for topic in frames]


KINDS: dict[str, Callable[[Path, foreign.Frames], list[Path]]] = {
    "csv": as_text(lambda path, frame: frame.to_csv(path, index=False), ".csv"),
    "parquet": as_text(lambda path, frame: frame.to_parquet(path, index=False), ".parquet"),
    "json-lines": as_text(foreign.write_lines, ".jsonl"),
    "ros1": lambda d, f: [foreign.write_ros1(d / "walk.bag", f, LATE_NS)],
    "ros2-sqlite3": lambda d, f: [foreign.write_ros2(d / "walk", f, LATE_NS)],
    "ros2-mcap": lambda d, f: [foreign.write_ros2(d / "walk", f, LATE_NS, StoragePlugin.MCAP)],
    "mcap-ros2": lambda d, f: [
        next(foreign.write_ros2(d / "walk", f, LATE_NS, StoragePlugin.MCAP).glob("*.mcap"))
    ],
    "mcap-json": lambda d, f: [foreign.write_mcap(d / "walk.mcap", f)],
    "mat-v5": lambda d, f: [foreign.write_mat(d / "walk.mat", f)],
    "mat-v7.3": lambda d, f: [foreign.write_mat73(d / "walk.mat", f)],
    "hdf5": lambda d, f: [foreign.write_hdf5(d / "walk.h5", f)],
}


@pytest.mark.parametrize("kind", KINDS)
def test_every_column_of_a_walk_survives_any_kind_of_file(
    kind: str, frames: dict[str, pd.DataFrame], tmp_path: Path
) -> None:
    logs = converted(kind, frames, tmp_path)
    for log, frame in zip(logs, frames.values(), strict=True):
        written = pd.read_parquet(log)
        assert set(written) == set(frame)
        for name in frame:
            np.testing.assert_array_equal(written[name], frame[name], err_msg=f"{kind} {name}")


def test_a_converted_walk_is_read(
    frames: dict[str, pd.DataFrame], tmp_path: Path, run: Run
) -> None:
    logs = converted("ros1", frames, tmp_path)
    assert run("check", *logs, "--recipe", RECIPE, "--out", tmp_path / "out").exit_code == 0


QUICK = ("ros2-sqlite3",)
"""Replayed in each run of the tests; `make studies` replays all."""


@pytest.mark.parametrize(
    "kind", [k if k in QUICK else pytest.param(k, marks=pytest.mark.slow) for k in KINDS]
)
def test_a_walk_gives_the_same_calibration_from_any_kind_of_file(
    kind: str, frames: dict[str, pd.DataFrame], wanted: dict[str, float], tmp_path: Path
) -> None:
    found = replayed(converted(kind, frames, tmp_path), tmp_path / "out")
    assert found.keys() == wanted.keys()
    for name, value in wanted.items():
        assert found[name] == pytest.approx(value, rel=1e-9, abs=1e-9), name


# ------------------------------------------------------------------ stamps of messages
@pytest.fixture
def late_bag(tmp_path: Path) -> Path:
    """Five rows measured every 10 ms from an absolute time on, recorded 3 ms later."""
    stamps = EPOCH_NS + 10_000_000 * np.arange(5)
    frame = pd.DataFrame({"time_ns": stamps, "load": np.array([1.0, 2.0, 3.0, 4.0, 5.0])})
    return foreign.write_ros2(tmp_path / "late", {"scale": frame}, LATE_NS)


@pytest.mark.parametrize(("asked", "late_ns"), [("header", 0), ("log", LATE_NS)])
def test_the_header_stamp_counts_unless_the_log_time_is_asked_for(
    late_bag: Path, asked: str, late_ns: int, tmp_path: Path, run: Run
) -> None:
    out = tmp_path / "scale.parquet"
    answer = run("convert", late_bag, "--time", asked, "--out", out)
    assert answer.exit_code == 0, answer.err
    assert f"{asked} time" in answer.out
    written = pd.read_parquet(out)
    assert written["time_ns"].dtype == np.int64
    assert written["time_ns"].tolist() == [EPOCH_NS + 10_000_000 * i + late_ns for i in range(5)]


# ------------------------------------------------------------------ joins
@pytest.fixture
def two_clocks(tmp_path: Path) -> Path:
    """Forces at 0, 10, 20, 30 ms; temperatures at −1, 12 and 20 ms (after an absolute time)."""
    ms = 1_000_000
    force = pd.DataFrame({"time_ns": EPOCH_NS + ms * np.array([0, 10, 20, 30]),
                          "fz": [1.0, 2.0, 3.0, 4.0]})  # fmt: skip
    heat = pd.DataFrame(
        {"time_ns": EPOCH_NS + ms * np.array([-1, 12, 20]), "t": [20.0, 21.0, 22.0]}
    )
    return foreign.write_ros2(tmp_path / "two", {"force": force, "heat": heat})


@pytest.mark.parametrize(
    ("how", "tolerance_s", "expected"),
    [
        ("nearest", "0.005", [20.0, 21.0, 22.0, np.nan]),
        ("nearest", "0.02", [20.0, 21.0, 22.0, 22.0]),
        ("previous", "0.02", [20.0, 20.0, 22.0, 22.0]),
        ("previous", "0.0085", [20.0, np.nan, 22.0, np.nan]),
    ],
)
def test_topics_are_joined_within_the_stated_distance_only(
    two_clocks: Path, how: str, tolerance_s: str, expected: list[float], tmp_path: Path, run: Run
) -> None:
    out = tmp_path / "all.parquet"
    answer = run("convert", two_clocks, "--join", how, "--clock", "/force",
                 "--tolerance-s", tolerance_s, "--out", out)  # fmt: skip
    assert answer.exit_code == 0, answer.err
    written = pd.read_parquet(out)
    assert written["force.fz"].tolist() == [1.0, 2.0, 3.0, 4.0]
    np.testing.assert_array_equal(written["heat.t"], expected)
    missing = int(np.isnan(expected).sum())
    assert f"{missing} of 4 rows of force have no heat within {float(tolerance_s)} s" in answer.out


def test_a_join_without_a_distance_is_refused(two_clocks: Path, tmp_path: Path, run: Run) -> None:
    answer = run("convert", two_clocks, "--join", "nearest", "--out", tmp_path / "all.parquet")
    assert answer.exit_code == 2
    assert "--tolerance-s" in answer.err


# ------------------------------------------------------------------ refusals
def halved(path: Path) -> Path:
    content = path.read_bytes()
    path.write_bytes(content[: len(content) // 2 - 3])  # within a line of text
    return path


def small(n: int = 300) -> dict[str, pd.DataFrame]:
    values = np.random.default_rng(1).normal(size=n)
    return {"cells": pd.DataFrame({"time_ns": EPOCH_NS + np.arange(n), "a": values})}


BROKEN: dict[str, Callable[[Path], Path]] = {
    "ros1": lambda d: halved(foreign.write_ros1(d / "a.bag", small())),
    "mcap": lambda d: halved(foreign.write_mcap(d / "a.mcap", small())),
    "mat-v5": lambda d: halved(foreign.write_mat(d / "a.mat", small())),
    "mat-v7.3": lambda d: halved(foreign.write_mat73(d / "a.mat", small(5000))),
    "hdf5": lambda d: halved(foreign.write_hdf5(d / "a.h5", small(5000))),
    "c3d": lambda d: halved(foreign.write_c3d(d / "a.c3d")),
    "json-lines": lambda d: halved(foreign.write_lines(d / "a.jsonl", small()["cells"])),
}


def broken_ros2(folder: Path) -> Path:
    bag = foreign.write_ros2(folder / "a", small(3000))
    halved(next(bag.glob("*.db3")))
    return bag


def short_mot(folder: Path) -> Path:
    path = folder / "a.mot"
    path.write_text("a\nnRows=3\nnColumns=2\nendheader\ntime\tf\n0\t1\n1\t2\n")
    return path


@pytest.mark.parametrize("make", [*BROKEN.values(), broken_ros2, short_mot],
                         ids=[*BROKEN, "ros2", "mot"])  # fmt: skip
def test_a_truncated_file_is_one_line_and_leaves_nothing(
    make: Callable[[Path], Path], tmp_path: Path, run: Run
) -> None:
    (tmp_path / "raw").mkdir()
    answer = run("convert", make(tmp_path / "raw"), "--out", tmp_path / "out")
    assert answer.exit_code == 3, answer.err
    assert answer.err.startswith("footcal: error: ")
    assert answer.err.count("\n") == 1
    assert not list((tmp_path / "out").glob("*")) if (tmp_path / "out").exists() else True


@pytest.mark.parametrize(
    ("module", "make", "extra"),
    [
        ("rosbags.highlevel", lambda d: foreign.write_ros1(d / "a.bag", small()), "ros"),
        ("mcap.reader", lambda d: foreign.write_mcap(d / "a.mcap", small()), "mcap"),
        ("ezc3d", lambda d: foreign.write_c3d(d / "a.c3d"), "c3d"),
        ("h5py", lambda d: foreign.write_hdf5(d / "a.h5", small()), "hdf5"),
    ],
)
def test_a_missing_library_is_answered_by_the_command_that_installs_it(
    module: str, make: Callable[[Path], Path], extra: str, tmp_path: Path, run: Run,
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    source = make(tmp_path)
    monkeypatch.setitem(sys.modules, module, None)  # what Python does without the package
    answer = run("convert", source, "--out", tmp_path / "out")
    assert answer.exit_code == 2
    assert f"pip install 'footcal[{extra}]'" in answer.err


def test_header_stamps_that_were_never_set_are_refused(tmp_path: Path, run: Run) -> None:
    store = get_typestore(Stores.ROS2_HUMBLE)
    types, name = store.types, "geometry_msgs/msg/PointStamped"
    stamp = types["builtin_interfaces/msg/Time"](0, 0)
    point = types[name](
        types["std_msgs/msg/Header"](stamp, "foot"), types["geometry_msgs/msg/Point"](1.0, 2.0, 3.0)
    )
    with Writer2(tmp_path / "bag", version=9) as bag:
        link = bag.add_connection("/p", name, typestore=store)
        for i in range(3):
            bag.write(link, EPOCH_NS + i, store.serialize_cdr(point, name))
    answer = run("convert", tmp_path / "bag", "--out", tmp_path / "p.parquet")
    assert answer.exit_code == 3
    assert "--time log" in answer.err
    answer = run("convert", tmp_path / "bag", "--time", "log", "--out", tmp_path / "p.parquet")
    assert answer.exit_code == 0, answer.err
    written = pd.read_parquet(tmp_path / "p.parquet")
    assert written["point.y_m"].tolist() == [2.0, 2.0, 2.0]


def test_several_tables_do_not_go_into_one_file(two_clocks: Path, tmp_path: Path, run: Run) -> None:
    answer = run("convert", two_clocks, "--out", tmp_path / "one.parquet")
    assert answer.exit_code == 2
    assert "--topic" in answer.err
    assert "--join" in answer.err


def test_a_file_that_is_there_stays_unless_overwritten(
    late_bag: Path, tmp_path: Path, run: Run
) -> None:
    out = tmp_path / "scale.parquet"
    out.write_text("mine")
    assert run("convert", late_bag, "--out", out).exit_code == 2
    assert out.read_text() == "mine"
    assert run("convert", late_bag, "--out", out, "--overwrite").exit_code == 0
    assert len(pd.read_parquet(out)) == 5
    assert not list(tmp_path.glob(".*"))


def test_a_misspelt_topic_is_answered_by_the_nearest(
    two_clocks: Path, tmp_path: Path, run: Run
) -> None:
    answer = run("convert", two_clocks, "--topic", "/forse", "--out", tmp_path / "a.parquet")
    assert answer.exit_code == 2
    assert "did you mean '/force'" in answer.err


def test_a_recipe_names_sources_and_topics(two_clocks: Path, tmp_path: Path, run: Run) -> None:
    recipe = tmp_path / "r.toml"
    recipe.write_text('[data]\nconvert = "two"\n[convert]\ntopics = ["/heat"]\ntime = "log"\n')
    answer = run("convert", "--recipe", recipe, "--out", tmp_path / "heat.parquet")
    assert answer.exit_code == 0, answer.err
    assert "log time" in answer.out
    assert pd.read_parquet(tmp_path / "heat.parquet")["t"].tolist() == [20.0, 21.0, 22.0]


def test_a_message_that_grows_on_the_way_is_refused(tmp_path: Path, run: Run) -> None:
    with (tmp_path / "a.mcap").open("wb") as stream:
        writer = McapWriter(stream)
        writer.start()
        schema = writer.register_schema("cells", "jsonschema", b"{}")
        channel = writer.register_channel("/cells", "json", schema)
        for i, content in enumerate(({"fl": 1}, {"fl": 1, "fr": 2})):
            writer.add_message(channel, i, json.dumps(content).encode(), i)
        writer.finish()  # type: ignore[no-untyped-call] # mcap types all but this
    answer = run("convert", tmp_path / "a.mcap", "--out", tmp_path / "a.parquet")
    assert answer.exit_code == 3
    assert "fr is not in its first message" in answer.err
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a.mcap"]
