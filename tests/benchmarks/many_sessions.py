"""`make many`: what `batch` costs per session, and whether all its ways give one table."""

from __future__ import annotations

import argparse
import os
import resource
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pandas as pd

_SINGLE = 9
"""Runs of a command by itself, as a shell loop starts them."""
_LADDER_N = np.array([0, 2, 5, 10, 15, 20, 25, 20, 15, 10, 5, 2, 0] * 3, dtype=float)[:34]
_OWN = ("attempts", "seconds")
"""Columns in which runs of the same sessions may differ."""
_KILLED_AFTER = 0.2


def sessions(count: int, out: Path) -> Path:
    """Weights on one cell, a file per day; their table."""
    out.mkdir(parents=True, exist_ok=True)
    rng, rows = np.random.default_rng(1), []
    for k in range(count):
        force = _LADDER_N * (1.0 + 0.002 * rng.normal()) + rng.normal(0.0, 0.02, _LADDER_N.size)
        log = pd.DataFrame({
            "channel": "left_fl", "load_n": _LADDER_N,
            "counts": np.round((force - 284.0) / -3.41e-5).astype(np.int64),
        })  # fmt: skip
        log.to_csv(out / f"s{k:03d}.csv", index=False)
        day = (np.datetime64("2020-01-01") + k).astype(str)
        rows.append({"session": f"s{k:03d}", "robot": "one", "date": day, "logs": f"s{k:03d}.csv"})
    pd.DataFrame(rows).to_csv(out / "sessions.csv", index=False)
    return out / "sessions.csv"


def _spent() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def _footcal(words: Sequence[str]) -> list[str]:
    return [sys.executable, "-m", "footcal_cli", *words, "--no-pictures", "--quiet"]


def _run(name: str, words: Sequence[str], count: int) -> float:
    """Say what so many sessions cost; CPU seconds of one."""
    before, began = _spent(), time.monotonic()
    code = subprocess.run(_footcal(words), check=False, capture_output=True).returncode
    spent, lasted = _spent() - before, time.monotonic() - began
    sys.stdout.write(
        f"{name}: {spent:.1f} s of CPU, {lasted:.1f} s elapsed, "
        f"{1e3 * spent / count:.0f} ms per session, exit code {code}\n"
    )
    sys.stdout.flush()
    return spent / count


def _batch(table: Path, command: str, out: Path, *more: str) -> list[str]:
    return ["batch", str(table), "--command", command, "--out", str(out), "--overwrite", *more]


def _killed(table: Path, out: Path, count: int) -> None:
    """Two workers, of which one is killed once a fifth of the sessions are done."""
    shutil.rmtree(out, ignore_errors=True)
    batch = subprocess.Popen(_footcal(_batch(table, "check", out, "--workers", "2")))
    while len(list((out / "rows").glob("*.json"))) < _KILLED_AFTER * count:
        time.sleep(0.01)
    done = len(list((out / "rows").glob("*.json")))
    children = Path(f"/proc/{batch.pid}/task/{batch.pid}/children").read_text(encoding="ascii")
    worker = max(map(int, children.split()), key=_cpu_ticks)
    os.kill(worker, signal.SIGKILL)
    sys.stdout.write(f"a worker killed after {done} sessions: exit code {batch.wait()}\n")


def _cpu_ticks(pid: int) -> int:
    fields = Path(f"/proc/{pid}/stat").read_text(encoding="ascii").rsplit(")", 1)[1].split()
    return int(fields[11]) + int(fields[12])


@contextmanager
def _cluster(workers: int) -> Iterator[str]:
    """Address of a Dask cluster on this machine."""
    from distributed import LocalCluster

    with LocalCluster(  # type: ignore[no-untyped-call]
        n_workers=workers, threads_per_worker=1, dashboard_address=None
    ) as cluster:
        yield str(cluster.scheduler_address)


def _table(out: Path) -> pd.DataFrame:
    return pd.read_parquet(out / "sessions.parquet").drop(columns=list(_OWN), errors="ignore")


def _compare(name: str, one: Path, other: Path) -> None:
    same = _table(one).equals(_table(other))
    attempts = int(pd.read_parquet(other / "sessions.parquet")["attempts"].max())
    sys.stdout.write(f"{name}: {'same table' if same else 'ANOTHER TABLE'}, {attempts} attempts\n")
    sys.stdout.flush()


def main() -> None:
    """Make the sessions, run them every way."""
    parser = argparse.ArgumentParser(prog="python -m tests.benchmarks.many_sessions")
    parser.add_argument("--sessions", type=int, default=200)
    parser.add_argument("--out", type=Path, default=Path("out/many"))
    given = parser.parse_args()
    count, out = given.sessions, given.out.resolve()
    table = sessions(count, out / "logs")
    single = ["check", str(table.parent / "s000.csv"), "--out", str(out / "one"), "--overwrite"]
    loop = min(_run("check by itself", single, 1) for _ in range(_SINGLE))
    for command in ("check", "offline-fit"):
        for workers in ("1", "2"):
            words = _batch(table, command, out / f"{command}_{workers}", "--workers", workers)
            own = _run(f"batch --command {command}, workers {workers}", words, count)
            if command == "check":
                sys.stdout.write(f"a loop takes {loop / own:.0f} times as long (CPU)\n")
        _compare(f"{command}, two workers", out / f"{command}_1", out / f"{command}_2")
    _killed(table, out / "killed", count)
    _compare("one killed", out / "check_1", out / "killed")
    with _cluster(2) as address:
        words = _batch(table, "check", out / "dask", "--scheduler", address)
        _run("batch --command check, Dask, first process alone", words, count)
    _compare("Dask", out / "check_1", out / "dask")


if __name__ == "__main__":
    main()
