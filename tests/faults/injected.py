"""Kills at chosen and random moments, a machine that fails, and two writers of one folder."""

from __future__ import annotations

import errno
import json
import os
import resource
import shutil
import signal
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

from tests.faults.bases import BASES, Base
from tests.faults.forked import AtTouch, Ended, count_touches, start
from tests.faults.judging import fingerprint, laid_out, read_back, spoken, touched, words_in
from tests.faults.running import Job, Outcome

TRIED = (
    "weights", "together", "stand", "hang", "apply", "check_weights", "check_walk", "diagnose",
    "simulate", "batch", "kinematics",
)  # fmt: skip
_SIGNALS = {signal.SIGKILL: "SIGKILL", signal.SIGTERM: "SIGTERM", signal.SIGINT: "SIGINT"}
_EXIT_CODES = {signal.SIGTERM: 143, signal.SIGINT: 130}


def _bases() -> Iterator[Base]:
    return (BASES[name] for name in TRIED if name in BASES)


def kills(inputs: Path, seed: int) -> list[Job]:
    """Every command killed where it touches files, and at random moments."""
    jobs = []
    for base in _bases():
        rng = np.random.default_rng((seed, *base.name.encode()))
        times = {signal.SIGKILL: 4, signal.SIGTERM: 2, signal.SIGINT: 2}
        moments = [(number, f) for number, n in times.items() for f in rng.uniform(size=n)]
        for number, share in moments:
            name = f"{base.name} | {_SIGNALS[number]} at {100 * share:.0f} % of its file accesses"
            run = partial(_killed, base, inputs, number, share, name)
            jobs.append(Job(name, "kill", _SIGNALS[number], run))
        for number, after_s in zip(_SIGNALS, rng.uniform(0.01, 1.5, 3), strict=True):
            name = f"{base.name} | {_SIGNALS[number]} after {after_s:.2f} s"
            run = partial(_killed, base, inputs, number, -after_s, name)
            jobs.append(Job(name, "kill", _SIGNALS[number], run))
    return jobs


def _killed(
    base: Base, inputs: Path, number: signal.Signals, share: float, name: str, folder: Path
) -> Outcome:
    """Kill at a share of the file accesses, or after −`share` seconds; then run once more."""
    earlier = int(abs(share) * 1e6) % 2 == 0
    laid_out(base, inputs, folder)
    words = _words(base, folder)
    touches = _ran(base, inputs, folder, result=earlier)["all"]
    before = fingerprint(folder)

    def arm() -> None:
        if share < 0:
            signal.setitimer(signal.ITIMER_REAL, -share)
            signal.signal(signal.SIGALRM, lambda *_: os.kill(os.getpid(), number))
            return
        at = 1 + int(share * touches)
        AtTouch(folder, at, lambda: os.kill(os.getpid(), number)).install()

    ended = start(words, folder.parent / f"{folder.name}.err", arm).wait()
    broken = _after(base, folder, before, earlier)
    if number == signal.SIGKILL:
        broken = [b for b in broken if "partial" not in b and "old" not in b]
        finished = ended.code >= 0
    else:
        finished = ended.code in (0, 1)
        if not finished and ended.code != _EXIT_CODES[number]:
            broken.append(f"exit code {ended.code}, expected {_EXIT_CODES[number]}")
        if not finished and len(ended.err.strip().splitlines()) != 1:
            broken.append(f"{len(ended.err.strip().splitlines())} lines of error")
    if not finished:
        again = start(words, folder.parent / f"{folder.name}.err").wait()
        if again.code not in (0, 1):
            broken.append(f"the next run ends with {again.code}")
        broken += _after(base, folder, before, earlier, whole=True)
    return _outcome(name, "kill", _SIGNALS[number], ended, broken, folder)


def _ran(base: Base, inputs: Path, folder: Path, *, result: bool) -> dict[str, int]:
    """File accesses of an untroubled run, worked out once; its result is put into the folder."""
    kept = inputs / "ran" / base.name
    if not kept.is_dir():
        words, new = _words(base, folder), inputs / f"ran_{os.getpid()}"
        touches = {"writing": count_touches(words, folder, writing=True)}
        touches["all"] = count_touches(words, folder)
        new.mkdir()
        (folder / base.out).rename(new / "result")
        (new / "touches.json").write_text(json.dumps(touches), "utf-8")
        kept.parent.mkdir(exist_ok=True)
        if not kept.is_dir():
            new.rename(kept)
    if result:
        shutil.copytree(kept / "result", folder / base.out)
    counted: dict[str, int] = json.loads((kept / "touches.json").read_text("utf-8"))
    return counted


def machine_faults(inputs: Path, seed: int) -> list[Job]:
    """A full disk, a limit on files, an error of the medium, no permission, no memory."""
    jobs = []
    for base in _bases():
        rng = np.random.default_rng((seed, 7, *base.name.encode()))
        for kind, code, times in (
            ("full disk", errno.ENOSPC, 2), ("medium fails", errno.EIO, 1),
            ("too many open files", errno.EMFILE, 1), ("no permission to write", errno.EACCES, 1),
        ):  # fmt: skip
            for share in rng.uniform(size=times):
                name = f"{base.name} | {kind} at {100 * share:.0f} % of its file accesses"
                run = partial(_failing, base, inputs, code, share, name, kind)
                jobs.append(Job(name, "machine", kind, run))
        size = int(rng.integers(100, 20_000))
        memory_mb = int(rng.integers(2, 30))
        for kind, words, arm in (
            ("file size limit", f"{size} bytes", partial(_limit_size, size)),
            ("out of memory", f"{memory_mb} MB more", partial(_limit_memory, memory_mb)),
        ):
            name = f"{base.name} | {kind}, {words}"
            run = partial(_limited, base, inputs, arm, name, kind)
            jobs.append(Job(name, "machine", kind, run))
    return jobs


def _failing(
    base: Base, inputs: Path, code: int, share: float, name: str, kind: str, folder: Path
) -> Outcome:
    """From a share of the accesses on, all of them fail."""
    laid_out(base, inputs, folder)
    words = _words(base, folder)
    writing = code in (errno.ENOSPC, errno.EACCES)
    touches = _ran(base, inputs, folder, result=True)["writing" if writing else "all"]
    before = fingerprint(folder)

    def fail() -> None:
        raise OSError(code, os.strerror(code), str(folder / "somewhere"))

    arm = AtTouch(folder, 1 + int(share * touches), fail, writing).install
    ended = start(words, folder.parent / f"{folder.name}.err", arm).wait()
    found = _of_machine(base, folder, before, ended, name, kind)
    if writing:
        return found
    # where nothing can be removed any more, the next run removes it
    kept = tuple(v for v in found.violations if ".partial" not in v)
    return replace(found, violations=kept)


def _limited(
    base: Base, inputs: Path, arm: Callable[[], None], name: str, kind: str, folder: Path
) -> Outcome:
    laid_out(base, inputs, folder)
    before = fingerprint(folder)
    ended = start(_words(base, folder), folder.parent / f"{folder.name}.err", arm).wait()
    return _of_machine(base, folder, before, ended, name, kind, earlier=False)


def _limit_size(size: int) -> None:
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))


def _limit_memory(more_mb: int) -> None:
    pages = int(Path("/proc/self/statm").read_text("ascii").split()[0])
    limit = pages * resource.getpagesize() + more_mb * 2**20
    resource.setrlimit(resource.RLIMIT_AS, (limit, limit))


def _of_machine(
    base: Base, folder: Path, before: dict[str, tuple[str, int]], ended: Ended, name: str,
    kind: str, *, earlier: bool = True,
) -> Outcome:  # fmt: skip
    """The machine's fault has its own code and one sentence; or it was not met at all."""
    broken = _after(base, folder, before, earlier)
    if ended.code not in (0, 1, 74):
        broken.append(f"exit code {ended.code}, expected 74")
    if ended.code == 74 and len(ended.err.strip().splitlines()) != 1:
        broken.append(f"{len(ended.err.strip().splitlines())} lines of error")
    return _outcome(name, "machine", kind, ended, broken, folder)


def races(inputs: Path, _seed: int) -> list[Job]:
    """Two runs that write the same folder at the same time."""
    jobs = []
    for base in _bases():
        for overwrite in (True, False):
            name = f"{base.name} | two writers, {'with' if overwrite else 'without'} --overwrite"
            run = partial(_race, base, inputs, overwrite, name)
            jobs.append(Job(name, "race", "two writers", run))
    return jobs


def _race(base: Base, inputs: Path, overwrite: bool, name: str, folder: Path) -> Outcome:
    laid_out(base, inputs, folder)
    words = _words(base, folder)
    if not overwrite:
        words.remove("--overwrite")
    before = fingerprint(folder)
    go, release = os.pipe()

    def together() -> None:
        os.close(release)
        os.read(go, 1)  # returns when the parent closes its end

    both = [start(words, folder.parent / f"{folder.name}.err{i}", together) for i in (0, 1)]
    os.close(release)
    ended = [each.wait() for each in both]
    os.close(go)
    broken = _after(base, folder, before, earlier=True)
    won = [each for each in ended if each.code in (0, 1)]
    lost = [each for each in ended if each.code not in (0, 1)]
    if not won:
        broken.append(f"both failed: {ended[0].err.strip()[:200]}")
    broken += [f"the loser ends with {e.code}" for e in lost if e.code != 2]
    if len(won) == 2 and not overwrite:
        broken.append("both wrote the folder")
    return _outcome(name, "race", "two writers", (lost or ended)[0], broken, folder)


def _words(base: Base, folder: Path) -> list[str]:
    return [*words_in(base, folder), "--out", str(folder / base.out), "--overwrite"]


def _after(
    base: Base, folder: Path, before: dict[str, tuple[str, int]], earlier: bool, *,
    whole: bool = False,
) -> list[str]:  # fmt: skip
    """Promises about what lies there, however a run ended."""
    broken = touched(base, folder, before)
    out = folder / base.out
    if not out.exists():
        return broken + (["the earlier result is gone"] if earlier else [])
    if not base.grows:
        return broken + _half(out)
    # sessions that are done stay, each of them whole; a summary is whole or not there
    sessions = list((out / "sessions").iterdir()) if (out / "sessions").is_dir() else []
    if whole or (out / "run.json").is_file():
        broken += _half(out, but=("rows", "sessions"))
    return broken + [b for each in sessions if whole or each.name[0] != "." for b in _half(each)]


def _half(out: Path, but: tuple[str, ...] = ()) -> list[str]:
    """What a folder of results lacks, or holds besides; some of its folders are not looked at."""
    run, faults = read_back(out)
    if run is not None:
        there = {p.relative_to(out) for p in out.rglob("*") if p.is_file()}
        if {p.as_posix() for p in there if p.parts[0] not in but} != {"run.json", *run.files}:
            faults.append("half a result")
    return faults


def _outcome(
    name: str, part: str, family: str, ended: Ended, broken: list[str], folder: Path
) -> Outcome:  # fmt: skip
    lines = ended.err.strip().splitlines()
    broken += [b for b in spoken(ended.code, ended.err) if "traceback" in b or "70" in b]
    shutil.rmtree(folder, ignore_errors=True)
    said = lines[-1].replace(f"{folder}/", "") if lines else ""
    return Outcome(name, part, family, ended.code, said[:300], "", tuple(dict.fromkeys(broken)))
