"""Tables, recipe and truth of a recording, and how they are written."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd


@dataclass(frozen=True)
class Recorded:
    """What an experiment in this world leaves behind.

    Parameters
    ----------
    logs : canonical tables by their role in a recipe's ``[data]``
    robot : the recipe's ``[robot]``, as its owner believes it to be
    truth : what was true, by name; parameters are named as in ``parameters.json``
    commands : options of commands, by the recipe's table
    """

    logs: Mapping[str, pd.DataFrame]
    robot: Mapping[str, Any]
    truth: Mapping[str, Any]
    commands: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)


def joined(*parts: Recorded) -> Recorded:
    """Several experiments of one robot under one recipe; the first one's truth."""
    return Recorded(
        {role: log for part in parts for role, log in part.logs.items()},
        parts[0].robot,
        parts[0].truth,
        {name: options for part in parts for name, options in part.commands.items()},
    )


def write(recorded: Recorded, folder: Path) -> Path:
    """Write Parquet tables, ``truth.json`` and ``recipe.toml``; returns the recipe."""
    folder.mkdir(parents=True, exist_ok=True)
    for role, frame in recorded.logs.items():
        frame.to_parquet(folder / f"{role}.parquet", index=False)
    truth = json.dumps(recorded.truth, default=lambda v: np.asarray(v).tolist(), indent=1)
    (folder / "truth.json").write_text(truth, encoding="utf-8")
    lines = ['name = "foreign"', "", *_table("robot", recorded.robot)]
    lines += ["[data]", *(f'{role} = "{role}.parquet"' for role in recorded.logs), ""]
    for command, options in recorded.commands.items():
        lines += _table(command, options)
    recipe = folder / "recipe.toml"
    recipe.write_text("\n".join(lines), encoding="utf-8")
    return recipe


def _table(path: str, content: Mapping[str, Any]) -> list[str]:
    lines = [f"[{path}]"]
    lines += [f"{k} = {_value(v)}" for k, v in content.items() if not isinstance(v, Mapping)]
    lines.append("")
    for key, value in content.items():
        if isinstance(value, Mapping):
            lines += _table(f"{path}.{key}", value)
    return lines


def _value(value: object) -> str:
    if isinstance(value, (str, bool)):
        return json.dumps(value)
    if isinstance(value, (list, tuple, np.ndarray)):
        return "[" + ", ".join(_value(v) for v in value) + "]"
    return str(value) if isinstance(value, int) else repr(float(value))  # type: ignore[arg-type]
