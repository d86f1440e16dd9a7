"""Making one trial of the plan: a world drawn, effects hidden at their sizes, logs written."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from tests.blind.hidden import CATALOGUE
from tests.blind.loops import widest_loop_n
from tests.blind.oracle import limits
from tests.blind.plan import Cell
from tests.blind.whitening import inputs_of
from tests.blind.world import GRAVITY_MPS2, Array, World
from tests.blind.worlds import WORLDS
from tests.blind.yardstick import UnreachableError, Yardstick, size_for, yardstick

MATTERS = 0.15
"""The tolerance given in the recipe, as a share of the noise: ρ 0.3 is twice what matters."""
FEW = {"weights": 2, "placements": 2, "walk": 0, "hang": 1, "pose": 12, "stand": 4}
"""Days, rows of holes, turns, poses, stances with too little data; a walk has seconds instead."""
FEW_SECONDS = 6.0
MOST_DRAWS = 12
GAINS = {
    "weights": ("force",),
    "placements": ("fz", "moment_x", "moment_y"),
}
"""Quantities whose held-out gain is comparable, in the order of the errors."""
LIMITED = ("single", "alias", "pair")
"""Kinds whose trials ask for names; the oracle says how often they can be given."""


@dataclass(frozen=True)
class Drawn:
    """A hidden world, and the clean one it came from.

    Parameters
    ----------
    effects
        What was hidden, for the ledger.
    alone
        The clean world with each effect alone, those of one size (switches) left out.
    rng
        Where its stream of random numbers stands.
    """

    clean: World
    world: World
    stick: Yardstick
    effects: list[dict[str, Any]]
    alone: list[World]
    rng: np.random.Generator


def drawn(cell: Cell, seed: int) -> Drawn:
    """Draw the hidden world of one trial.

    A world in which an effect cannot reach its ρ (it hides in the calibration) is drawn again.

    Raises
    ------
    UnreachableError
        No world of a dozen could hold the effect.
    """
    rng = np.random.default_rng(seed)
    maker = WORLDS[cell.experiment]
    for _ in range(MOST_DRAWS):
        clean = maker.draw(rng, _options(cell))
        stick = yardstick(maker, clean)
        try:
            world, effects, alone = _hide(cell, clean, stick, rng)
        except UnreachableError:
            continue
        return Drawn(clean, world, stick, effects, alone, rng)
    raise UnreachableError(f"{cell}: not reached in {MOST_DRAWS} worlds")


def make_trial(cell: Cell, seed: int, folder: Path) -> dict[str, Any]:
    """Write the logs of one trial; returns its truth.

    Raises
    ------
    UnreachableError
        No world of a dozen could hold the effect.
    """
    found = drawn(cell, seed)
    folder.mkdir(parents=True)
    WORLDS[cell.experiment].write(found.world, folder, found.rng)
    add_options(folder / "recipe.toml", found.clean, found.stick)
    return {
        "kind": cell.kind,
        "experiment": cell.experiment,
        "drift": cell.drift,
        "seed": seed,
        "rho": cell.rho,
        "left_out": cell.left_out,
        "effects": found.effects,
        "gain": _true_gain(found),
        "limit": _limit(cell, found),
        "facts": {k: v for k, v in found.clean.facts.items() if k not in ("legs", "build")},
    }


def _limit(cell: Cell, found: Drawn) -> dict[str, Any] | None:
    """What an oracle reaches, None where no name is asked for."""
    if cell.kind not in LIMITED:
        return None
    right = [effect["right"] for effect in found.effects]
    return limits(found.clean, found.stick, found.alone, right)


def _true_gain(found: Drawn) -> dict[str, float]:
    """Share of the RMS error that goes when what was hidden is removed, by quantity.

    Only where readings are judged as they were taken: streams are filtered first, so that their
    noise is not the generator's.
    """
    world, stick = found.world, found.stick
    if world.experiment not in GAINS:
        return {}
    rows = np.maximum(stick.valid.sum(axis=0), 1)
    # what the converter rounds off is noise that no model removes
    reach = np.sum(inputs_of(found.clean, stick).reach ** 2, axis=(0, 1)) / rows
    noise = rows * (stick.noise**2 + reach * world.quantum_n**2 / 12.0)
    left = np.sum((stick.left(world) * stick.noise) ** 2, axis=0)
    if world.experiment == "weights":  # cells are judged together
        noise, left = noise.sum(keepdims=True), left.sum(keepdims=True)
    share = 1.0 - np.sqrt(noise / (noise + left))
    return dict(zip(GAINS[world.experiment], share.tolist(), strict=True))


def add_options(recipe: Path, clean: World, stick: Yardstick) -> None:
    """The smallest errors that matter: a fixed share of the noise, in N and in mm of CoP.

    The calibration to start from is scale and bias: what a bench without suspicion makes.
    """
    torque = np.array([name.endswith("m") for name in _output_units(clean)])
    smallest = _smallest(clean, stick)
    force_n = float(smallest[~torque][0])
    lines = ["[offline_fit]", 'models = "affine"', "", "[diagnose]", f"tolerance_n = {force_n:.4g}"]
    if torque.any():
        lines.append(f"tolerance_mm = {1000.0 * smallest[torque][0] / _carried_n(clean):.4g}")
    if "delay_s" in clean.facts:
        lines.append(f"delay_s = {clean.facts['delay_s']:.4g}")
    with recipe.open("a", encoding="utf-8") as stream:
        stream.write("\n".join(lines) + "\n")


def _smallest(clean: World, stick: Yardstick) -> Array:
    """The smallest error that matters, per output, N or Nm, shape (k,)."""
    torque = np.array([name.endswith("m") for name in _output_units(clean)])
    out = np.full(torque.size, MATTERS * float(np.median(stick.noise[~torque])))
    if torque.any():
        out[torque] = MATTERS * float(np.median(stick.noise[torque]))
    return out


def _output_units(world: World) -> list[str]:
    if world.experiment == "weights":
        return ["N"] * len(world.channels)
    if world.experiment in ("hang", "pose"):
        legs = len(world.robot["legs"]) if world.experiment == "hang" else 1
        return ["N", "N", "N", "Nm", "Nm", "Nm"] * legs
    return ["N", "Nm", "Nm"] + ["N"] * (8 if world.experiment != "placements" else 0)


def _carried_n(world: World) -> float:
    """The load whose centre the tolerance in mm is meant for."""
    if world.experiment == "placements":
        return float(world.row["load_n"].max())
    if world.experiment == "hang":
        return float(world.row["weight_n"].mean())
    return float(world.robot["mass_kg"]) * GRAVITY_MPS2


def _options(cell: Cell) -> dict[str, Any]:
    # level and late streams are aliases where nothing turns
    options: dict[str, Any] = {"drift": cell.drift, "straight": cell.kind == "alias"}
    if cell.kind == "underpowered":
        options["blocks"] = FEW[cell.experiment]
        options["seconds"] = FEW_SECONDS
    return options


def _hide(
    cell: Cell, clean: World, stick: Yardstick, rng: np.random.Generator
) -> tuple[World, list[dict[str, Any]], list[World]]:
    """Inject every effect of a cell at its size, measured in the clean world."""
    world, effects, every = clean, [], []
    for key in cell.hidden:
        item = CATALOGUE[key]
        sign = float(rng.choice([-1.0, 1.0])) if item.signed else 1.0
        place = int(rng.integers(2**63))
        size, rho, matters, stated = item.guess, float("nan"), float("nan"), None
        if not item.switch:
            size, alone = size_for(
                cell.rho,
                lambda s, item=item, sign=sign, place=place: item.act(  # type: ignore[misc]
                    clean, sign * s, np.random.default_rng(place)
                ),
                stick,
                item.guess,
                item.most,
            )
            every.append(alone)
            rho, matters = stick.rho(alone), stick.matters(alone, _smallest(clean, stick))
            stated = widest_loop_n(clean, alone) if "hysteresis" in item.right else sign * size
        world = item.act(world, sign * size, np.random.default_rng(place))
        effects.append(
            {
                "key": key,
                "right": list(item.right),
                "alias": list(item.alias),
                "size": sign * size,
                "stated": stated,
                "unit": item.unit,
                "parameter": item.parameter,
                "foreign": item.foreign,
                "place": place,
                "rho": None if item.switch else rho,
                "matters": None if item.switch else matters,
            }
        )
    return world, effects, every
