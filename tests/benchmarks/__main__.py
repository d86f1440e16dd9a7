"""`make bench`: ratios measured in one run, written to docs/benchmarks.md."""

from __future__ import annotations

import argparse
import os
import platform
import subprocess
import sys
import time
from datetime import date
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from statistics import median

from footcal_cli import __version__
from tests.benchmarks.contenders import Contender, contenders
from tests.benchmarks.diagnoses import diagnosed, lines_of
from tests.benchmarks.fits import fitted, lines_of_fits
from tests.benchmarks.limits import FLAGS, compiler

PAGE = Path(__file__).resolve().parents[2] / "docs" / "benchmarks.md"
_LONGEST_S = 1.0
_MICRO = 1e6
_DIAGNOSES = 2


def measured(one: Contender, rounds: int) -> list[float]:
    """CPU seconds per unit of every round, after one to warm up."""
    began = time.process_time()
    one.run()
    repeats = max(int(0.02 / max(time.process_time() - began, 1e-4)), 1)
    times: list[float] = []
    spent = 0.0
    while len(times) < rounds and (spent < _LONGEST_S * rounds or len(times) < 3):
        began = time.process_time()
        for _ in range(repeats):
            one.run()
        lasted = time.process_time() - began
        spent += lasted
        times.append(lasted / repeats / one.units)
    return times


def page_of(
    results: list[tuple[Contender, list[float]]],
    fits: list[tuple[str, list[float]]],
    diagnoses: list[tuple[str, list[float]]],
    before: float,
) -> str:
    """The page: a table per kernel, of fits, of whole diagnoses; `before`: the load before."""
    lines = [
        "# Benchmarks",
        "Written by `make bench`. CPU time per update of a 20 s walk (8 cells at 80 Hz, 20 updates "
        "per second): median and range over the rounds of one run, all in one process. Compare the "
        "ratios; the absolute times are those of this machine. The C limits "
        f"(`tests/benchmarks/limits.c`, `{' '.join(FLAGS)}`) do the same operations with sizes "
        "known to the compiler; those of the filter get rows and noise ready made. Contenders "
        "give the same answers (`tests/benchmarks/test_online.py`).",
        "",
    ]
    groups = list(dict.fromkeys(one.group for one, _ in results))
    for group in groups:
        own = [(one, times) for one, times in results if one.group == group]
        best = {one.name: median(times) for one, times in own}
        limit = best.get("C limit")
        lines += [
            f"## {group[0].upper()}{group[1:]}",
            "| | µs | range | × compiled | × C |",
            "|---|---|---|---|---|",
        ]
        for one, times in own:
            low, high = _MICRO * min(times), _MICRO * max(times)
            against = f"{best[one.name] / limit:.1f}" if limit else "–"
            lines.append(
                f"| {one.name} | {_MICRO * best[one.name]:.3g} | {low:.3g} to {high:.3g} (n "
                f"{len(times)}) | {best[one.name] / best['compiled']:.2g} | {against} |"
            )
        lines.append("")
    lines += [*lines_of_fits(fits), *lines_of(diagnoses), moment(before), versions()]
    return "\n".join(lines) + "\n"


def moment(before: float) -> str:
    """When, which code, and how many processes ran: the load before and after."""
    asked = ["git", "describe", "--always", "--dirty", "--exclude=*"]
    done = subprocess.run(asked, cwd=PAGE.parent, capture_output=True, text=True, check=False)
    code = f", commit {done.stdout.strip()}" if done.returncode == 0 else ""
    after = os.getloadavg()[0]
    return (
        f"Measured on {date.today().isoformat()}{code}, under a load of {before:.1f} at the start "
        f"and {after:.1f} at the end ({os.cpu_count()} processors; 1 is this process alone).\n"
    )


def versions() -> str:
    """What was measured with."""
    names = ["numpy", "scipy", "pandas", "numba"]
    found = []
    for name in names:
        try:
            found.append(f"{name} {version(name)}")
        except PackageNotFoundError:
            found.append(f"{name} not installed")
    return (
        f"footcal {__version__}, Python {platform.python_version()}, {', '.join(found)}; "
        f"{platform.machine()}, {compiler() or 'no C compiler'}."
    )


def main() -> None:
    """Measure and write."""
    parser = argparse.ArgumentParser(prog="python -m tests.benchmarks")
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--out", type=Path, default=PAGE)
    given = parser.parse_args()
    before = os.getloadavg()[0]
    results = []
    for one in contenders():
        times = measured(one, given.rounds)
        results.append((one, times))
        sys.stdout.write(f"{_MICRO * median(times):10.3f} µs  {one.group}: {one.name}\n")
        sys.stdout.flush()
    fits = []
    for name, times in fitted(given.rounds):
        fits.append((name, times))
        sys.stdout.write(f"{1e3 * min(times):10.2f} ms  {name}\n")
        sys.stdout.flush()
    diagnoses = []
    for name, times in diagnosed(_DIAGNOSES):
        diagnoses.append((name, times))
        sys.stdout.write(f"{min(times):10.1f} s   {name}\n")
        sys.stdout.flush()
    given.out.write_text(page_of(results, fits, diagnoses, before), encoding="utf-8")


if __name__ == "__main__":
    main()
