"""Errors of walks and stands over their Cramér–Rao bounds, robot by robot."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from tests.foreign.kinds import kind_of
from tests.foreign.least import known_before, least, rows_of
from tests.foreign.least_ankles import least_ankles

Bounds = Mapping[str, list[list[float]]]
"""Quantity -> least sd of each value, load known and with the estimator of the body."""
_CELLS = (
    "static-init", "online-replay", "static-init, nameplate", "online-replay, nameplate",
    "static-init, true nameplate", "online-replay, true nameplate", "static-init, mounted anew",
    "online-replay, mounted anew",
)  # fmt: skip


def bounds_of(name: str, seed: int, folder: Path) -> Bounds:
    """Bounds of one task; none where nobody has worked them out. Kept in `folder`."""
    kind = kind_of(seed)
    known = name in _CELLS or "ankles" in name
    if not known or kind.legs or kind.hysteresis:
        return {}
    kept = folder / f"{seed}" / "least.json"
    all_of = json.loads(kept.read_text(encoding="utf-8")) if kept.exists() else {}
    if name not in all_of:
        if "ankles" in name:
            all_of[name] = least_ankles(seed, name)
        else:
            what = "walk" if name.startswith("online") else "stand"
            rows = rows_of(seed, what)
            for task in _CELLS:
                if task.startswith(name.partition(",")[0]):
                    alone, body = least(rows, known_before(seed, task))
                    all_of[task] = {
                        quantity: np.stack([alone[:, i], body[:, i]], axis=1).tolist()
                        for i, quantity in enumerate(("scale", "zero"))
                    }
        kept.parent.mkdir(parents=True, exist_ok=True)
        kept.write_text(json.dumps(all_of), encoding="utf-8")
    return dict(all_of[name])


def spreads(
    task: str, quantity: str, answers: Mapping[tuple[str, int], Mapping[str, Any]],
    bounds: Mapping[tuple[str, int], Bounds],
) -> tuple[str, str]:  # fmt: skip
    """RMS error of a robot over its bounds: median over robots, and quartiles."""
    found = []
    for key, answer in answers.items():
        each = np.array(bounds.get(key, {}).get(quantity, []))
        pairs = np.array(answer["ratios"].get(quantity, []))
        if key[0] == task and len(each) and len(each) == len(pairs):
            found.append([_rms(pairs[:, 0] / each[:, i]) for i in (0, 1)])
    if not found:
        return "–", "–"
    load, body = np.array(found).T
    return _spread(load), _spread(body)


def _rms(values: Any) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


def _spread(values: Any) -> str:
    """Median, and quartiles."""
    if not np.isfinite(values).all():
        return "–"
    low, middle, high = np.quantile(values, [0.25, 0.5, 0.75])
    return f"{middle:.2g} ({low:.2g}–{high:.2g})"
