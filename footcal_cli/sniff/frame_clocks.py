"""A counter of frames as a clock, at a rate that is said, or next to a stream that lasts as long.

Room: sniff; asked by walking.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from footcal_cli.sniff.guesses import ColumnGuess, FileGuess, numbers_of, seconds_of
from footcal_cli.sniff.plan import rate_said

_LEAST_FRAMES, _OFTEN = 100, 0.9
_SAME_LENGTH = 0.01
"""How far two recordings of one walk may differ in length, as a share of it."""
_MULTIPLES = 20


def at_said_rate(file: FileGuess) -> FileGuess:
    """A log without stamps whose frames are counted in s, where a line above says how fast."""
    rate, counters = rate_said(file), [c for c in file.of("sequence") if _counts_frames(c)]
    if file.of("time") or not counters or rate is None:
        return file
    return _with_clock(file, counters[0], rate, f"{rate:g} Hz are said")


def with_frame_clocks(files: Sequence[FileGuess]) -> list[FileGuess]:
    """Logs without stamps, their frames counted in s where the one body's stream says how fast."""
    bodies = [file for file in files if file.of("com") and file.of("time")]
    return [_counted(file, bodies[0]) if len(bodies) == 1 else file for file in files]


def _counted(file: FileGuess, body: FileGuess) -> FileGuess:
    counters = [c for c in file.of("sequence") if _counts_frames(c)]
    if file.of("time", "com") or not counters:
        return file
    counter = counters[0]
    rate = _rate(float(numbers_of(counter)[-1]), body)
    if rate is None:
        return file
    return _with_clock(file, counter, rate, f"frames at {rate:g} Hz last as long as "
                       f"{body.path.name}")  # fmt: skip


def _with_clock(file: FileGuess, counter: ColumnGuess, rate: float, why: str) -> FileGuess:
    clock = replace(
        counter, name=replace(counter.name, quantity="time", factor=1.0 / rate), unit="s",
        values=numbers_of(counter) / rate, sure="guess", why=why,
    )  # fmt: skip
    return replace(file, rate_hz=rate, columns=tuple(
        clock if c is counter else c for c in file.columns
    ))  # fmt: skip


def _counts_frames(column: ColumnGuess) -> bool:
    """Whether a column counts up by one in most rows, and leaves no more than some out."""
    if column.values is None or column.values.size < _LEAST_FRAMES:
        return False
    steps = np.diff(column.values)
    return bool(np.all(steps >= 1) and np.mean(steps == 1) > _OFTEN)


def _rate(last: float, body: FileGuess) -> float | None:
    """Frames per s: the body's rate, a multiple or a part of it, by which both end together."""
    stamps = seconds_of(body.of("time")[0])
    if stamps is None or not body.rate_hz or not np.nanmax(stamps) > 0:
        return None
    base, wanted = float(f"{body.rate_hz:.4g}"), last / float(np.nanmax(stamps))
    whole = range(1, _MULTIPLES + 1)
    rates = [*(base * k for k in whole), *(base / k for k in whole)]
    near = min(rates, key=lambda rate: abs(np.log(rate / wanted)))
    return near if abs(near / wanted - 1.0) < _SAME_LENGTH else None
