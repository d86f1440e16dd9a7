"""What differs between a run and its golden output, one line each."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

from tests.golden.runs import Kept

OUTPUTS = Path(__file__).parent / "outputs"
SD_SHARE = 1e-6
"""Values may move by this share of their sd, sds and numbers without one relative to themselves."""


def golden(name: str) -> Kept | None:
    """The golden output of a run, None where there is none yet."""
    path = OUTPUTS / f"{name}.json"
    return dict(json.loads(path.read_text(encoding="utf-8"))) if path.exists() else None


def differences(before: Kept, now: Kept) -> list[str]:
    """Lines that name what moved and by how much; no line where nothing did."""
    lines: list[str] = []
    for key in sorted({*before, *now}):
        old, new = before.get(key), now.get(key)
        if isinstance(old, dict) and isinstance(new, dict):
            for name in sorted({*old, *new}):
                line = _changed(old.get(name), new.get(name))
                lines += [f"{key}, {name}: {line}"] if line else []
        elif old != new:
            lines.append(f"{key}: {old} -> {new}")
    return lines


def _changed(old: Any, new: Any) -> str:
    if isinstance(old, list) and isinstance(new, list):
        (value, sd, status), (value_now, sd_now, status_now) = old, new
        if status != status_now:
            return f"{status} -> {status_now}"
        if sd and sd_now and value is not None and value_now is not None:
            if abs(value_now - value) > SD_SHARE * sd:
                return (
                    f"moved by {(value_now - value) / sd:.3g} sd ({value:.9g} -> {value_now:.9g})"
                )
            return _number(sd, sd_now, "sd ")
        return _number(sd, sd_now, "sd ") or _number(value, value_now)
    return _number(old, new)


def _number(old: Any, new: Any, what: str = "") -> str:
    both = isinstance(old, float | int) and isinstance(new, float | int)
    same = old == new or (both and math.isclose(old, new, rel_tol=SD_SHARE, abs_tol=1e-12))
    return "" if same else f"{what}{old} -> {new}"
