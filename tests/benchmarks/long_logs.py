"""`make long`: CPU time and memory of commands on long logs, one line per run."""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from scipy.signal import lfilter

REPOSITORY = Path(__file__).resolve().parents[2]
RECIPE = REPOSITORY / "recipes" / "nao_simulated.toml"
_PIECE_S, _HOLD_S, _CREEP_S, _CREEP, _RATE_HZ = 600.0, 600.0, 120.0, 0.003, 80.0
_LADDER_N = np.array([0, 10, 20, 30, 40, 50, 60, 50, 40, 30, 20, 10], dtype=float)


def walk(hours: float, out: Path) -> tuple[Path, Path]:
    """Cells and body of a walk: ten simulated minutes, again and again."""
    piece = out / "piece"
    if not piece.exists():
        _footcal(
            "simulate", "--recipe", str(RECIPE), "--experiment", "walk",
            "--duration-s", str(_PIECE_S), "--no-pictures", "--quiet", "--out", str(piece),
        )  # fmt: skip
    paths = []
    for name in ("cells", "body"):
        table = pq.read_table(piece / f"{name}.parquet")
        paths.append(out / f"{name}_{hours:g}h.parquet")
        stamps = table.column_names.index("time_s")
        with pq.ParquetWriter(paths[-1], table.schema) as writer:
            for k in range(round(hours * 3600 / _PIECE_S)):
                late = pa.array(table["time_s"].to_numpy() + k * _PIECE_S)
                writer.write_table(table.set_column(stamps, table.schema.field(stamps), late))
    return paths[0], paths[1]


def day(hours: float, out: Path) -> tuple[Path, Path]:
    """Weights on one cell that creeps, ten minutes each, and its recipe."""
    time_s = np.arange(round(hours * 3600 * _RATE_HZ)) / _RATE_HZ
    load = _LADDER_N[(time_s / _HOLD_S).astype(int) % _LADDER_N.size]
    keep = np.exp(-1.0 / (_RATE_HZ * _CREEP_S))
    creep = _CREEP * lfilter([1.0 - keep], [1.0, -keep], load)
    force = load + creep + np.random.default_rng(1).normal(0.0, 0.02, load.size)
    counts = np.round((force - 284.0) / -3.41e-5).astype(np.int64)
    log, recipe = out / f"weights_{hours:g}h.parquet", out / "weights.toml"
    pq.write_table(pa.table({"time_s": time_s, "load_n": load, "cell_counts": counts}), log)
    recipe.write_text('[robot]\nchannels = ["cell"]\n', encoding="utf-8")
    return log, recipe


def _footcal(*words: str) -> tuple[int, float, float, float]:
    """Exit code, CPU seconds, elapsed seconds and largest resident memory in GiB."""
    began = time.monotonic()
    started = subprocess.Popen([sys.executable, "-m", "footcal_cli", *words, "--overwrite"])
    _, status, used = os.wait4(started.pid, 0)
    started.returncode = os.waitstatus_to_exitcode(status)
    spent = used.ru_utime + used.ru_stime
    return started.returncode, spent, time.monotonic() - began, used.ru_maxrss / 2**20


def _runs(hours: float, out: Path) -> Iterator[tuple[str, list[str]]]:
    """Name and words of each command."""
    cells, body = (str(path) for path in walk(hours, out))
    own = ["--recipe", str(RECIPE)]
    yield "check", ["check", cells, *own]
    yield "online-replay", ["online-replay", cells, body, *own]
    calibration = str(out / "online-replay" / "parameters.json")
    yield "apply", ["apply", cells, *own, "--parameters", calibration]
    log, recipe = day(3.0 * hours, out)
    yield f"offline-fit, {3 * hours:g} h of weights", [
        "offline-fit", str(log), "--recipe", str(recipe),
    ]  # fmt: skip


def main() -> None:
    """Make the logs, run the commands."""
    parser = argparse.ArgumentParser(prog="python -m tests.benchmarks.long_logs")
    parser.add_argument("--hours", type=float, nargs="+", default=[1.0, 2.0, 4.0, 8.0])
    parser.add_argument("--commands", nargs="*", help="only those")
    parser.add_argument("--out", type=Path, default=Path("out/long"))
    given = parser.parse_args()
    given.out.mkdir(parents=True, exist_ok=True)
    for hours in given.hours:
        for name, words in _runs(hours, given.out):
            if given.commands and words[0] not in given.commands:
                continue
            code, cpu_s, elapsed_s, memory = _footcal(
                *words, "--quiet", "--out", str(given.out / words[0])
            )
            sys.stdout.write(
                f"{hours:g} h: {name}: {cpu_s:.1f} s of CPU, {elapsed_s:.1f} s elapsed, "
                f"{memory:.2f} GiB, exit code {code}\n"
            )
            sys.stdout.flush()


if __name__ == "__main__":
    main()
