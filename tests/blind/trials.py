"""The plan of a bench: which effects, how large, how often; and making one trial of it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np

from tests.blind.hidden import CATALOGUE, Injection, hidden_in
from tests.blind.world import GRAVITY_MPS2, World
from tests.blind.worlds import WORLDS
from tests.blind.yardstick import UnreachableError, Yardstick, size_for, yardstick

Kind = Literal[
    "null", "single", "switch", "pair", "unseen", "left_out", "small", "underpowered", "untestable"
]
EXPERIMENTS = ("weights", "placements", "walk", "hang", "pose", "stand")
SINGLE_RHO = (0.3, 0.5, 1.0)
UNSEEN_RHO = (0.6, 1.0)
PAIR_RHO = 0.6
MATTERS = 0.15
"""The tolerance given in the recipe, as a share of the noise: ρ 0.3 is twice what matters."""
SMALL_RHO = 0.05
FEW = {"weights": 2, "placements": 2, "walk": 0, "hang": 1, "pose": 12, "stand": 4}
"""Days, rows of holes, turns, poses, stances with too little data; a walk has seconds instead."""
FEW_SECONDS = 6.0
MOST_DRAWS = 12
CURVES = ("nonlinearity", "nonlinearity_cubic", "saturation", "hinge", "dead_zone")
"""Names of one curve, more or less well described."""


@dataclass(frozen=True)
class Cell:
    """One line of the plan.

    Parameters
    ----------
    kind
        What is asked of the diagnosis.
    experiment
        Where.
    hidden
        Keys of `CATALOGUE`.
    rho
        Wanted size of each; 0 for a switch.
    drift
        Whether a walk's calibration wanders.
    left_out
        Effect taken out of the library before the diagnosis.
    """

    kind: Kind
    experiment: str
    hidden: tuple[str, ...] = ()
    rho: float = 0.0
    drift: bool = False
    left_out: str = ""


def plan_cells(experiments: Sequence[str] = EXPERIMENTS) -> tuple[Cell, ...]:
    """Every line of the bench; a run repeats the whole list."""
    cells: list[Cell] = []
    for experiment in experiments:
        seen = hidden_in(experiment, unseen=False)
        drifts = (False, True) if experiment == "walk" else (False,)
        for drift in drifts:
            # nulls are needed by the hundred: as many as a tenth of the singles in each round
            cells += [Cell("null", experiment, drift=drift)] * 4
            cells += [
                Cell("single", experiment, (item.key,), rho, drift)
                for item in seen
                for rho in SINGLE_RHO
            ]
            cells += [
                Cell("unseen", experiment, (item.key,), rho, drift)
                for item in hidden_in(experiment, unseen=True)
                for rho in UNSEEN_RHO
            ]
        for item in CATALOGUE.values():
            if item.switch and experiment in item.experiments:
                # a mass hides in the drifting scales of a walk; wiring does not
                kind: Kind = "untestable" if item.right == ("mass",) else "switch"
                cells.append(Cell(kind, experiment, (item.key,), drift=experiment == "walk"))
        cells += [
            Cell("left_out", experiment, (item.key,), 1.0, left_out=_family(item)) for item in seen
        ]
        cells += [Cell("pair", experiment, pair, PAIR_RHO) for pair in _pairs(seen)]
        cells.append(Cell("small", experiment, (seen[0].key,), SMALL_RHO))
        cells += [Cell("underpowered", experiment, hidden, 1.0) for hidden in ((), (seen[0].key,))]
    return tuple(cells)


def _family(item: Injection) -> str:
    """The names that must be taken out with an effect: a cubic is no wrong name for a curve."""
    curve = "nonlinearity" in item.right
    return " ".join(dict.fromkeys((*item.right, *(CURVES if curve else ()))))


def _pairs(seen: Sequence[Injection]) -> Iterator[tuple[str, str]]:
    """Each effect with the next one of another name that does not share its alias group."""
    for i, first in enumerate(seen):
        for second in (*seen[i + 1 :], *seen[:i]):
            if not set(first.right) & set(second.right) and not set(first.alias) & set(
                second.right
            ):
                yield first.key, second.key
                break


def make_trial(cell: Cell, seed: int, folder: Path) -> dict[str, Any]:
    """Write the logs of one trial; returns its truth.

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
            world, effects = _hide(cell, clean, stick, rng)
        except UnreachableError:
            continue
        gain = _true_gain(world, stick)
        folder.mkdir(parents=True)
        maker.write(world, folder, rng)
        _add_options(folder / "recipe.toml", clean, stick)
        return {
            "kind": cell.kind,
            "experiment": cell.experiment,
            "drift": cell.drift,
            "seed": seed,
            "rho": cell.rho,
            "left_out": cell.left_out,
            "effects": effects,
            "gain": gain,
            "facts": {k: v for k, v in clean.facts.items() if k != "legs"},
        }
    raise UnreachableError(f"{cell}: not reached in {MOST_DRAWS} worlds")


def _true_gain(world: World, stick: Yardstick) -> dict[str, float]:
    """Share of the RMS error that goes when what was hidden is removed, by quantity.

    Only for weights: streams are filtered and placements averaged before they are judged, so that
    their noise is not the generator's.
    """
    if world.experiment != "weights":
        return {}
    rows = np.maximum(stick.valid.sum(axis=0), 1)
    noise = float(np.sum(rows * stick.noise**2))
    left = float(np.sum((stick.left(world) * stick.noise) ** 2))
    return {"force": 1.0 - float(np.sqrt(noise / (noise + left)))}


def _add_options(recipe: Path, clean: World, stick: Yardstick) -> None:
    """The smallest errors that matter: a fixed share of the noise, in N and in mm of CoP.

    The calibration to start from is scale and bias: what a bench without suspicion makes.
    """
    torque = np.array([name.endswith("m") for name in _output_units(clean)])
    force_n = MATTERS * float(np.median(stick.noise[~torque]))
    lines = ["[offline_fit]", 'models = "affine"', "", "[diagnose]", f"tolerance_n = {force_n:.4g}"]
    if torque.any():
        moment_nm = MATTERS * float(np.median(stick.noise[torque]))
        lines.append(f"tolerance_mm = {1000.0 * moment_nm / _carried_n(clean):.4g}")
    with recipe.open("a", encoding="utf-8") as stream:
        stream.write("\n".join(lines) + "\n")


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
    options: dict[str, Any] = {"drift": cell.drift}
    if cell.kind == "underpowered":
        options["blocks"] = FEW[cell.experiment]
        options["seconds"] = FEW_SECONDS
    return options


def _hide(
    cell: Cell, clean: World, stick: Yardstick, rng: np.random.Generator
) -> tuple[World, list[dict[str, Any]]]:
    """Inject every effect of a cell at its size, measured in the clean world."""
    world, effects = clean, []
    for key in cell.hidden:
        item = CATALOGUE[key]
        sign = float(rng.choice([-1.0, 1.0])) if item.signed else 1.0
        place = int(rng.integers(2**63))
        size, rho = item.guess, float("nan")
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
            rho = stick.rho(alone)
        world = item.act(world, sign * size, np.random.default_rng(place))
        effects.append(
            {
                "key": key,
                "right": list(item.right),
                "alias": list(item.alias),
                "size": sign * size,
                "unit": item.unit,
                "parameter": item.parameter,
                "foreign": item.foreign,
                "rho": None if item.switch else rho,
            }
        )
    return world, effects
