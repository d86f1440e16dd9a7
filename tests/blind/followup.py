"""The experiment that a diagnosis proposed, made with the same robot and the same hidden effect."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from tests.blind.diagnosing import ADDED, BEFORE
from tests.blind.hidden import CATALOGUE
from tests.blind.plan import Cell
from tests.blind.trials import add_options, drawn
from tests.blind.worlds import WORLDS
from tests.blind.worlds.proposed import SETTLED, can_make, proposed
from tests.blind.yardstick import yardstick

NOT_ON_A_BENCH = (
    "com_offset", "imu_tilt", "accel_bias", "floor_slope", "angular_momentum", "mass", "delay",
    "lag", "load_bypass", "hanging_plate", "cell_position",
)  # fmt: skip
"""What belongs to the body, its telemetry or the foot: single cells under weights know nothing."""
NOT_ON_A_PLATE = tuple(n for n in NOT_ON_A_BENCH if n not in ("load_bypass", "cell_position"))
"""Weights on the holes of a foot show the foot, and nothing of the body."""
NOT_IN_THE_AIR = ("case_strain", "robot_weight", "leg_weight")
"""What ground or a belief does: a robot that hangs presses no case, and hangs with its shoes on."""
ABSENT = {"weights": NOT_ON_A_BENCH, "placements": NOT_ON_A_PLATE, "hang": NOT_IN_THE_AIR}


def wants_followup(truth: Mapping[str, Any], said: Mapping[str, Any]) -> bool:
    """Whether a designed alias was answered with rivals and an experiment that can be made."""
    proposal = said.get("next_experiment") or {}
    return (
        truth["kind"] == "alias"
        and bool(said.get("rivals"))
        and can_make(str(proposal.get("id", "")))
    )


def left_open(truth: Mapping[str, Any], said: Mapping[str, Any]) -> bool:
    """Whether a designed alias was answered with rivals, but with nothing on the menu."""
    proposal = said.get("next_experiment") or {}
    return truth["kind"] == "alias" and bool(said.get("rivals")) and not proposal.get("id")


def make_followup(
    truth: Mapping[str, Any], said: Mapping[str, Any], seed: int, folder: Path
) -> Path:
    """Write the logs of the proposed experiment, and what proposed it; returns their folder."""
    proposal = said["next_experiment"]
    keys = tuple(str(effect["key"]) for effect in truth["effects"])
    cell = Cell(truth["kind"], truth["experiment"], keys, truth["rho"], truth["drift"])
    before = drawn(cell, int(truth["seed"]))
    rng = np.random.default_rng(seed)
    clean = proposed(rng, str(proposal["id"]), before.clean, int(proposal.get("repeats") or 1))
    # shapes stay what they are, however far the new loads reach
    clean = replace(clean, facts={**clean.facts, "span_n": before.clean.span_n})
    world = clean
    gone = (*ABSENT.get(clean.experiment, ()), *SETTLED.get(str(proposal["id"]), ()))
    for key, effect in zip(keys, truth["effects"], strict=True):
        if key.split("/")[0] in gone:
            continue
        world = CATALOGUE[key].act(world, effect["size"], np.random.default_rng(effect["place"]))
    maker = WORLDS[clean.experiment]
    folder.mkdir(parents=True)
    maker.write(world, folder, rng)
    add_options(folder / "recipe.toml", clean, yardstick(maker, clean))
    with (folder / "recipe.toml").open("a", encoding="utf-8") as stream:
        stream.write(f"without = {json.dumps(proposal.get('without') or [])}\n")
    before_it = {key: value for key, value in said.items() if key not in ADDED}
    (folder / BEFORE).write_text(json.dumps(before_it), "utf-8")
    return folder
