"""What a run said: every number with its sd, and the words a machine may rely on."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

_OF_THE_LOG = ("session", "phase_rad", "counts")
"""Columns that an answer repeats as the log has them."""


@dataclass(frozen=True)
class Facts:
    """Numbers with their sd (0 where there is none), and words.

    Parameters
    ----------
    numbers
        Name -> value and sd; a negative sd is not compared.
    words
        Verdict and findings.
    """

    numbers: Mapping[str, tuple[float, float]]
    words: tuple[str, ...]

    def save(self, path: Path) -> None:
        """Write to a file, whole or not at all."""
        new = path.with_suffix(f".{os.getpid()}")
        new.write_text(json.dumps([dict(self.numbers), self.words]), "utf-8")
        new.rename(path)

    @classmethod
    def load(cls, path: Path) -> Facts:
        """Read back."""
        numbers, words = json.loads(path.read_text("utf-8"))
        return cls({name: (value, sd) for name, (value, sd) in numbers.items()}, tuple(words))


def facts_of(out: Path) -> Facts:
    """The facts of a run folder."""
    run = json.loads((out / "run.json").read_text("utf-8"))
    codes = sorted({f["code"] for f in run["findings"]})
    numbers: dict[str, tuple[float, float]] = {}
    for path in sorted(out.glob("parameters*.json")):
        known = json.loads(path.read_text("utf-8"))["parameters"]
        numbers |= {f"{path.stem}/{n}": (p["value"], p["sd"] or 0.0) for n, p in known.items()}
    for path in sorted(out.glob("*.parquet")):
        table = pd.read_parquet(path).select_dtypes("number")
        for name in [n for n in table.columns if n not in _OF_THE_LOG]:
            values = table[name].to_numpy(dtype=float)
            seen = values[np.isfinite(values)]
            if seen.size:
                numbers[f"{path.stem}/{name}"] = (float(seen.mean()), float(seen.std()))
    if (out / "diagnosis.json").is_file():
        found = json.loads((out / "diagnosis.json").read_text("utf-8"))
        codes += [found["verdict"], *(f"{c['effect']} {c['where']}" for c in found["causes"])]
    return Facts(numbers, (run["verdict"]["level"], *codes))


def differences(
    was: Facts, now: Facts, *, sds: float, relative: float = 1e-9, words: bool = True
) -> list[str]:
    """Where two runs disagree.

    Parameters
    ----------
    sds
        Values may differ by so many sd, sds by this share (1e-6 at least).
    relative
        And values besides by this share of themselves.
    words
        Whether verdict and findings must be the same.
    """
    broken = []
    for name in sorted(was.numbers.keys() ^ now.numbers.keys()):
        broken.append(f"{name} is in one only")
    for name in sorted(was.numbers.keys() & now.numbers.keys()):
        (value, sd), (other, other_sd) = was.numbers[name], now.numbers[name]
        if sd < 0:
            sd = other_sd
        if abs(other - value) > sds * sd + relative * abs(value) + 1e-12:
            apart = f"{abs(other - value) / sd:.3g} sd" if sd else f"{other - value:.3g}"
            broken.append(f"moved: {name} by {apart}")
        elif abs(other_sd - sd) > max(sds, 1e-6) * sd + 1e-12:
            broken.append(f"moved: sd of {name} from {sd:.4g} to {other_sd:.4g}")
    if words and was.words != now.words:
        broken.append(f"said {' '.join(was.words)}, then {' '.join(now.words)}")
    return broken
