"""``footcal online-replay`` of a walk in parts, against the same walk as a whole."""

from __future__ import annotations

from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from footcal_cli.core.online.noise import WalkNoise
from footcal_cli.intake import long_walks, walk_length
from footcal_cli.records.files import read_record
from footcal_cli.records.results import ParametersRecord, RmseRecord, RunRecord
from footcal_cli.tables import longfiles
from tests.cli.walk_files import write_belief, write_walk
from tests.conftest import Run
from tests.core.walk_data import CHANNELS, Errors, Recording, make_walk, record

ERRORS = Errors(
    bias_walk=0.03, gain_walk=4e-4, quantum=0.25, delay=0.022, com_offset=(0.003, -0.002)
)
LAST_BODY_S = 24.0
"""The body stream ends before the sensors': the last part is dropouts in the end."""


@pytest.fixture(scope="module")
def walk() -> Recording:
    made = record(make_walk(0.04, 30.0, seed=5), ERRORS, seed=5)
    stamps = made.cell_time.copy()
    stamps[900] = stamps[899]
    keep = np.ones(stamps.size, dtype=bool)
    keep[1200:1230] = False
    body = made.body_time < LAST_BODY_S
    made = replace(
        made, body_time=made.body_time[body], com=made.com[body], acc=made.acc[body],
        angmom_rate=made.angmom_rate[body], feet=made.feet[body], yaw=made.yaw[body],
    )  # fmt: skip
    return replace(
        made, cell_time=stamps[keep], counts=made.counts[keep], force=made.force[keep],
        cells=made.cells[keep],
    )  # fmt: skip


@pytest.fixture
def short_parts(monkeypatch: pytest.MonkeyPatch) -> None:
    """Parts of ten seconds, files read 500 rows or 64 kB at a time."""
    for module, name, value in (
        (walk_length, "LONG_S", 15.0), (long_walks, "PART_S", 10.0), (long_walks, "AHEAD_S", 5.0),
        (walk_length, "_LEAST_BYTES", 1), (longfiles, "LONG_BYTES", 1),
        (longfiles, "PIECE_ROWS", 500), (longfiles, "PIECE_BYTES", 2**16),
    ):  # fmt: skip
        monkeypatch.setattr(module, name, value)


def options(*more: str) -> str:
    noise = [f"{f.name} = {getattr(WalkNoise(), f.name)}" for f in fields(WalkNoise)]
    lines = [
        "[online_replay]",
        "delay_s = 0.02",
        "align_delay = false",
        "hanging_plate = false",
        *more,
    ]
    return "\n".join([*lines, "[online_replay.noise]", *noise])


@pytest.mark.parametrize(("kind", "causal"), [("parquet", False), ("csv", True)])
def test_parts_give_the_answer_of_the_whole(
    run: Run, walk: Recording, tmp_path: Path, request: pytest.FixtureRequest, kind: str,
    causal: bool,
) -> None:  # fmt: skip
    recipe = write_walk(tmp_path, walk, options(f"causal = {str(causal).lower()}"))
    if kind == "csv":
        for name in ("cells", "body"):
            pd.read_parquet(tmp_path / f"{name}.parquet").to_csv(
                tmp_path / f"{name}.csv", index=False
            )
        text = recipe.read_text("utf-8")
        for name in ("cells", "body"):
            text = text.replace(f"{name}.parquet", f"{name}.csv")
        recipe.write_text(text, "utf-8")
    belief = write_belief(tmp_path, walk)
    command = ("online-replay", "--recipe", recipe, "--parameters", belief, "--no-pictures")
    assert run(*command, "--out", tmp_path / "whole").exit_code == 0
    request.getfixturevalue("short_parts")
    answer = run(*command, "--out", tmp_path / "parts")
    assert answer.exit_code == 0, answer.err

    both = [tmp_path / name for name in ("whole", "parts")]
    whole, parts = (read_record(ParametersRecord, out / "parameters.json") for out in both)
    for name, one in whole.parameters.items():
        ours = parts.parameters[name]
        assert one.sd is not None
        assert ours.value == pytest.approx(one.value, abs=1e-6 * one.sd)
        if not causal:
            assert ours.sd == pytest.approx(one.sd, rel=1e-6)

    theirs, frame = (pd.read_parquet(out / "replay.parquet") for out in both)
    assert list(frame) == list(theirs)
    for column in ("time_s", "gait_cycle", "left_contact", "used", "reason", "cop_valid"):
        pd.testing.assert_series_equal(frame[column], theirs[column])
    # a live run takes the slope of its newest sample from one side, at the end of each learning
    tolerance = 1e-3 if causal else 1e-5
    for column in (f"{channel}_n" for channel in CHANNELS):
        np.testing.assert_allclose(frame[column], theirs[column], atol=tolerance)

    expected, found = (read_record(RmseRecord, out / "rmse.json") for out in both)
    assert found.rejected == expected.rejected
    for row, true in zip(found.rows, expected.rows, strict=True):
        assert (row.quantity, row.stage, row.reference, row.n) == (
            true.quantity, true.stage, true.reference, true.n,
        )  # fmt: skip
        # the smoother sees 5 s ahead, and what the motion demands is known by it
        alike = true.reference == "truth" and true.stage != "smoother"
        assert row.rmse == pytest.approx(true.rmse, rel=1e-5 if alike else 0.1)

    records = [read_record(RunRecord, out / "run.json") for out in both]
    assert records[0].inputs == records[1].inputs
    assert records[0].rows == records[1].rows
    said = [{(f.code, f.where) for f in one.findings} for one in records]
    assert said[0] == said[1]
    page = (tmp_path / "parts/report.html").read_text("utf-8")
    assert "Run in 3 parts of" in page


def test_delay_and_noise_are_learnt_where_the_robot_walks(
    run: Run, walk: Recording, tmp_path: Path, short_parts: None, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The first part of the log is quiet standing, from which nothing can be learnt."""
    monkeypatch.setattr(long_walks, "PART_S", 20.0)
    first = int(np.searchsorted(walk.cell_time, 1.0))
    quiet = 1600
    noise = np.random.default_rng(0).normal(0.0, 0.1, (quiet, len(CHANNELS))) / walk.scale0
    still = np.round(walk.counts[first] + noise)
    stamps = np.arange(quiet) / 80.0
    counts = np.concatenate([still, walk.counts])
    body = int(np.searchsorted(walk.body_time, 1.0))
    ahead = np.arange(2000) / 100.0

    def held(values: np.ndarray) -> np.ndarray:
        return np.concatenate([np.repeat(values[body : body + 1], 2000, axis=0), values])

    moving = (np.arange(2000 + walk.body_time.size) >= 2000)[:, None]
    longer = replace(
        walk, cell_time=np.concatenate([stamps, walk.cell_time + 20.0]), counts=counts,
        force=np.concatenate([np.repeat(walk.force[first : first + 1], quiet, axis=0), walk.force]),
        body_time=np.concatenate([ahead, walk.body_time + 20.0]), com=held(walk.com),
        acc=held(walk.acc) * moving, angmom_rate=held(walk.angmom_rate) * moving,
        feet=held(walk.feet), yaw=held(walk.yaw),
    )  # fmt: skip
    recipe = write_walk(tmp_path, longer)
    answer = run(
        "online-replay", "--recipe", recipe, "--parameters", write_belief(tmp_path, walk),
        "--no-pictures", "--out", tmp_path / "out",
    )  # fmt: skip
    assert answer.exit_code == 0, answer.out
    page = (tmp_path / "out/report.html").read_text("utf-8")
    start = float(page.split(" min from ")[1].split(" s on")[0])
    assert start >= 20.0
