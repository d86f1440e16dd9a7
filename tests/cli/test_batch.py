"""`batch`: many sessions, a bad one, a dead worker, and going on where it stopped."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Generator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from footcal_cli.batch import rows
from footcal_cli.batch.local import run_here
from footcal_cli.batch.plan import Job, plan
from footcal_cli.batch.rows import digest_of, refused
from footcal_cli.commands.batch import recipe_logs, run_session
from footcal_cli.errors import UsageError
from footcal_cli.records.batch import SessionRecord
from tests.cli.killed_work import died, kill_once
from tests.conftest import REPOSITORY, Run

RECIPE = 'name = "bench"\n[robot]\nname = "A"\nchannels = ["left_fl"]\n'


def write_session(path: Path, bias: float, seed: int) -> None:
    rng = np.random.default_rng(seed)
    load = np.repeat([0.0, 5.0, 10.0, 20.0], 3)
    counts = (load - bias) / -3.4e-5 + rng.normal(0.0, 300.0, load.size)
    frame = pd.DataFrame({"channel": "left_fl", "load_n": load, "counts": counts.round()})
    frame.to_csv(path, index=False)


@pytest.fixture
def logs(tmp_path: Path) -> Path:
    """Four sessions of ``check``, the third of them bad."""
    for i in range(4):
        write_session(tmp_path / f"bench_2026-05-0{i + 1}.csv", 0.1, i)
    (tmp_path / "bench_2026-05-03.csv").write_text("channel,load_n,counts\nleft_fl,abc,3\n")
    (tmp_path / "recipe.toml").write_text(RECIPE)
    return tmp_path


def job_of(folder: Path, name: str) -> Job:
    return Job(
        name, "A", None, "", (folder / f"{name}.csv",), None, None, "check", 0,
        folder / "out", again=False,
    )  # fmt: skip


def test_a_machine_that_fails_has_its_own_code(
    logs: Path, monkeypatch: pytest.MonkeyPatch, run: Run
) -> None:
    def no_memory(session: object, jobs: list[Job]) -> Generator[SessionRecord]:
        yield from (refused(job, "", "not enough memory", 74) for job in jobs)

    monkeypatch.setattr("footcal_cli.commands.batch._rows", no_memory)
    result = run(
        "batch", logs / "bench_2026-05-01.csv", "--command", "check", "--workers", "1",
        "--recipe", logs / "recipe.toml", "--out", logs / "out",
    )  # fmt: skip
    assert result.exit_code == 74
    assert "not enough memory" in result.err


def test_a_killed_worker_loses_nothing(tmp_path: Path) -> None:
    (tmp_path / "out").mkdir()
    jobs = [job_of(tmp_path, f"s{i:02d}") for i in range(20)]
    found = {row.session: row for row in run_here(jobs, 2, kill_once, died)}
    assert sorted(found) == [job.name for job in jobs]
    assert (found["s05"].outcome, found["s05"].attempts) == ("done", 2)
    assert (found["s07"].outcome, found["s07"].attempts) == ("refused", 2)
    assert sum(row.outcome == "done" for row in found.values()) == 19


@pytest.mark.usefixtures("drawn")
def test_a_bad_session_is_a_row_and_the_others_are_kept(run: Run, logs: Path) -> None:
    out = logs / "out"
    arguments = (
        "batch", str(logs / "bench_*.csv"), "--recipe", logs / "recipe.toml", "--command", "check",
        "--out", out, "--workers", "1", "--quiet", "--no-pictures",
    )  # fmt: skip
    answer = run(*arguments)
    assert answer.exit_code == 1
    assert answer.err.count("\n") == 1
    assert "bench_2026-05-03.csv, column load_n, line 2" in answer.err
    table = pd.read_parquet(out / "sessions.parquet")
    assert table["outcome"].tolist() == ["done", "done", "refused", "done"]
    assert table["date"].tolist() == [f"2026-05-0{i}" for i in range(1, 5)]
    assert len(pd.read_csv(out / "sessions.csv")) == 4
    assert (out / "report.html").is_file()
    stamps = {p: p.stat().st_mtime_ns for p in out.glob("sessions/*/run.json")}
    assert len(stamps) == 3
    assert not list(out.rglob("*.png"))

    # the log is mended: only that session is run again
    write_session(logs / "bench_2026-05-03.csv", 0.1, 9)
    answer = run(*arguments)
    assert answer.exit_code == 0, answer.err
    assert {p: p.stat().st_mtime_ns for p in stamps} == stamps
    assert set(pd.read_parquet(out / "sessions.parquet")["outcome"]) == {"done"}


def test_a_row_carries_parameters_with_their_sd(logs: Path) -> None:
    common = job_of(logs, "bench_2026-05-01")
    fields = {"recipe": logs / "recipe.toml", "command": "offline-fit"}
    row = run_session(Job(**{**common.__dict__, **fields}))
    bias = row.parameters["left_fl.bias"]
    assert bias.sd is not None
    assert abs(bias.value - 0.1) < 4 * bias.sd
    assert row.outcome == "done"
    assert row.digest == digest_of(Job(**{**common.__dict__, **fields}), recipe_logs)


def test_a_table_names_sessions_robots_and_dates(tmp_path: Path) -> None:
    table = tmp_path / "sessions.csv"
    table.write_text(
        "robot,date,operator,logs\nA,2026-05-04,ann,cells.parquet; body.parquet\n"
        "B,2026-05-05T09:30,ben,other.csv\n"
    )
    one, two = plan([str(table)], job_of(tmp_path, "x"))
    assert (one.name, one.robot, one.date, one.operator) == ("cells", "A", "2026-05-04", "ann")
    assert [path.name for path in one.logs] == ["cells.parquet", "body.parquet"]
    assert two.date == "2026-05-05T09:30:00"
    toml = tmp_path / "sessions.toml"
    toml.write_text('[[session]]\nlogs = ["a.csv", "b.csv"]\ndate = 2026-05-04\n')
    (only,) = plan([str(toml)], job_of(tmp_path, "x"))
    assert (only.name, only.date, len(only.logs)) == ("a", "2026-05-04", 2)


def test_folders_of_a_glob_are_sessions_and_equal_names_are_distinguished(tmp_path: Path) -> None:
    for day in ("2026-05-04", "2026-05-05"):
        for name in ("cells", "body"):
            (tmp_path / day / "walk").mkdir(parents=True, exist_ok=True)
            (tmp_path / day / "walk" / f"{name}.csv").touch()
    jobs = plan([str(tmp_path / "*" / "walk")], job_of(tmp_path, "x"))
    assert [job.name for job in jobs] == ["2026-05-04-walk", "2026-05-05-walk"]
    assert [job.date for job in jobs] == ["2026-05-04", "2026-05-05"]
    assert [len(job.logs) for job in jobs] == [2, 2]


@pytest.mark.parametrize(
    ("content", "said"),
    [
        ("robbot,logs\nA,a.csv\n", "did you mean 'robot'"),
        ("logs,date\na.csv,4 May\n", "not a date"),
        ("logs\na.csv\na.csv\n", "two sessions are called 'a'"),
        ("logs\n", "no sessions"),
    ],
)
def test_a_wrong_table_is_refused_in_one_line(tmp_path: Path, content: str, said: str) -> None:
    table = tmp_path / "sessions.csv"
    table.write_text(content)
    with pytest.raises(UsageError, match=said):
        plan([str(table)], job_of(tmp_path, "x"))


@pytest.mark.slow
def test_local_processes_and_dask_give_the_same_table(run: Run, logs: Path) -> None:
    from distributed import LocalCluster

    tables = []
    with LocalCluster(  # type: ignore[no-untyped-call]
        n_workers=2, threads_per_worker=1, dashboard_address=None
    ) as cluster:
        for extra in ((), ("--scheduler", cluster.scheduler_address)):
            out = logs / f"out{len(extra)}"
            run("batch", str(logs / "bench_*.csv"), "--recipe", logs / "recipe.toml", "--command",
                "offline-fit", "--out", out, "--quiet", *extra)  # fmt: skip
            tables.append(pd.read_parquet(out / "sessions.parquet").drop(columns="seconds"))
    pd.testing.assert_frame_equal(tables[0], tables[1])


def _started(work: str, out: Path) -> subprocess.Popen[str]:
    """A process that runs one job, in a process group of its own."""
    out.mkdir()
    return subprocess.Popen(
        [sys.executable, "-m", "tests.cli.killed_work", work, str(out)], cwd=REPOSITORY,
        stderr=subprocess.PIPE, text=True, start_new_session=True,
    )  # fmt: skip


def _wait_for(path: Path, running: subprocess.Popen[str]) -> None:
    while not path.exists() or (path.name == "worker" and not path.read_text("utf-8")):
        assert running.poll() is None
        time.sleep(0.01)


def test_a_worker_ends_with_the_run_that_started_it(tmp_path: Path) -> None:
    """One that outlived a killed run, busy as it may be, would write beside the next one."""
    run = _started("busy_long", tmp_path / "out")
    mark = tmp_path / "out" / "worker"
    _wait_for(mark, run)
    run.kill()
    run.wait()
    assert run.stderr is not None
    run.stderr.close()
    for _ in range(20):
        if not _lives(int(mark.read_text("utf-8"))):
            return
        time.sleep(0.05)
    os.kill(int(mark.read_text("utf-8")), signal.SIGKILL)
    pytest.fail("the worker still runs")


def test_a_run_that_is_asked_to_end_leaves_no_half_session(tmp_path: Path) -> None:
    run = _started("write_long", tmp_path / "out")
    _wait_for(tmp_path / "out" / "worker", run)
    run.terminate()
    assert (run.communicate(timeout=30)[1], run.returncode) == ("", 143)
    assert list((tmp_path / "out" / "sessions").iterdir()) == []


@pytest.mark.skipif(not Path("/proc/self/task").is_dir(), reason="no list of child processes")
def test_a_worker_never_hears_ctrl_c_not_even_while_it_starts(tmp_path: Path) -> None:
    run = _started("write_long", tmp_path / "out")
    mark = tmp_path / "out" / "worker"
    while not mark.exists():
        assert run.poll() is None
        for child in Path(f"/proc/{run.pid}/task/{run.pid}/children").read_text("utf-8").split():
            os.kill(int(child), signal.SIGINT)
        time.sleep(0.01)
    os.killpg(run.pid, signal.SIGINT)
    assert (run.communicate(timeout=30)[1], run.returncode) == ("", 130)


def test_a_killed_batch_is_gone_on_with(run: Run, logs: Path) -> None:
    """Killed in its first session, and again when that one is done."""
    (logs / "bench_2026-05-03.csv").unlink()
    out = logs / "out"
    words = (
        "batch", str(logs / "bench_*.csv"), "--recipe", str(logs / "recipe.toml"), "--command",
        "check", "--out", str(out), "--workers", "1", "--quiet", "--no-pictures",
    )  # fmt: skip
    for waited in ("sessions", "rows/bench_2026-05-01.json"):
        running = subprocess.Popen(
            [sys.executable, "-m", "footcal_cli", *words], cwd=REPOSITORY, stderr=subprocess.PIPE,
            text=True,
        )  # fmt: skip
        _wait_for(out / waited, running)
        running.kill()
        running.communicate()
    first = out / "sessions" / "bench_2026-05-01" / "run.json"
    done = first.stat().st_mtime_ns
    answer = run(*words)
    assert answer.exit_code == 0, answer.err
    assert first.stat().st_mtime_ns == done
    assert pd.read_parquet(out / "sessions.parquet")["outcome"].tolist() == ["done"] * 3
    assert not list(out.rglob(".*"))


def test_a_row_never_stands_beside_the_folder_of_another_run(
    logs: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Killed between the folder of a second run and its row, then asked for the first one again."""
    one = job_of(logs, "bench_2026-05-01")
    other = replace(one, seed=1)
    assert run_session(one).outcome == "done"
    with monkeypatch.context() as patched:
        patched.setattr(rows, "row", _interrupted)
        with pytest.raises(KeyboardInterrupt):
            run_session(other)
    assert rows.done(one, rows.digest_of(one, recipe_logs)) is None
    assert run_session(one).outcome == "done"
    assert rows.done(one, rows.digest_of(one, recipe_logs)) is not None


def _interrupted(*_: object) -> None:
    raise KeyboardInterrupt


def _lives(number: int) -> bool:
    try:
        os.kill(number, 0)
    except ProcessLookupError:
        return False
    stat = Path(f"/proc/{number}/stat")  # one that nobody has waited for is dead all the same
    return not stat.is_file() or stat.read_text("utf-8").rpartition(")")[2].split()[0] != "Z"
