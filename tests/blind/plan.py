"""What a run of the bench hides, how often: lines of trials of one kind, taken in rounds.

A full run is `ROUNDS` rounds and hits every count exactly. Rounds are alike: an interrupted run has
the same mixture with fewer trials. Within a line the effects take turns.
"""

from __future__ import annotations

import random
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

from tests.blind.classes import CURVES
from tests.blind.hidden import Injection, hidden_in, switches_in

Kind = Literal[
    "null", "single", "alias", "switch", "pair", "unseen", "left_out", "small", "underpowered",
    "untestable",
]  # fmt: skip
EXPERIMENTS = ("weights", "placements", "walk", "hang", "pose", "stand")
ROUNDS = 30
SINGLE_RHO = (0.3, 0.5, 1.0)
ALIAS_RHO = (0.5, 1.0)
UNSEEN_RHO = (0.6, 1.0)
PAIR_RHO = 0.6
SMALL_RHO = 0.05
COUNTS: Mapping[Kind, int] = {
    "single": 30, "alias": 12, "switch": 8, "pair": 30, "unseen": 12, "left_out": 15,
    "small": 10, "underpowered": 8, "untestable": 10,
}  # fmt: skip
"""Trials of a line in a full run, at most."""
NULLS = {"weights": 100, "placements": 100, "walk": 30, "hang": 25, "pose": 25, "stand": 40}
"""More where one takes a second, so that the bound on false names is tight; walks twice."""
DEAR = ("hang", "pose")
"""Where one takes many seconds: half as many of everything but single effects."""


@dataclass(frozen=True)
class Cell:
    """What one trial is.

    Parameters
    ----------
    kind
        What is asked of the diagnosis.
    experiment
        Where.
    hidden
        Keys of the catalogue.
    rho
        Wanted size of each; 0 for a switch.
    drift
        Whether a walk's calibration wanders.
    left_out
        Effects taken out of the library before the diagnosis.
    """

    kind: Kind
    experiment: str
    hidden: tuple[str, ...] = ()
    rho: float = 0.0
    drift: bool = False
    left_out: str = ""


@dataclass(frozen=True)
class Line:
    """Trials of one kind, size and experiment, which take turns through `cells`."""

    cells: tuple[Cell, ...]
    count: int

    def so_far(self, rounds: int) -> int:
        """Trials after so many rounds."""
        return rounds * self.count // ROUNDS


@dataclass(frozen=True)
class Planned:
    """One trial of a run: what it is called, and what it is, first choice first.

    The later choices stand in where no robot holds the first at its size.
    """

    trial: str
    choices: tuple[Cell, ...]


def lines(experiments: Sequence[str] = EXPERIMENTS) -> tuple[Line, ...]:
    """Every line of the bench."""
    found = [line for experiment in experiments for line in _lines_of(experiment)]
    return tuple(line for line in found if line.cells)


def planned(
    rounds: int,
    experiments: Sequence[str] = EXPERIMENTS,
    kinds: Sequence[str] = (),
    first_round: int = 0,
) -> tuple[Planned, ...]:
    """All trials of some rounds, each round in an order of its own."""
    trials: list[Planned] = []
    chosen = [ln for ln in lines(experiments) if not kinds or ln.cells[0].kind in kinds]
    for number in range(first_round, first_round + rounds):
        whole: list[Planned] = []
        for line in chosen:
            first = line.cells[0]
            for n in range(line.so_far(number), line.so_far(number + 1)):
                turned = line.cells[n % len(line.cells) :] + line.cells[: n % len(line.cells)]
                name = f"{first.kind} {first.experiment} {first.drift} {first.rho} {first.hidden}"
                whole.append(Planned(f"{name} {n}", turned))
        random.Random(number).shuffle(whole)
        trials += whole
    return tuple(trials)


def _lines_of(experiment: str) -> Iterator[Line]:
    seen = hidden_in(experiment, unseen=False)
    plain = [item for item in seen if not item.alias]
    for drift in (False, True) if experiment == "walk" else (False,):
        yield Line((Cell("null", experiment, drift=drift),), NULLS[experiment])
        for rho in SINGLE_RHO:
            yield _line("single", experiment, plain, rho, drift)
        families = dict.fromkeys(item.alias for item in seen if item.alias)
        for family in families:
            alike = [item for item in seen if item.alias == family]
            for rho in ALIAS_RHO:
                yield _line("alias", experiment, alike, rho, drift)
        for rho in UNSEEN_RHO:
            yield _line("unseen", experiment, hidden_in(experiment, unseen=True), rho, drift)
    yield Line(
        tuple(
            Cell("left_out", experiment, (item.key,), 1.0, left_out=left_out_with(item))
            for item in plain
        ),
        count_of("left_out", experiment),
    )
    yield Line(
        tuple(Cell("pair", experiment, pair, PAIR_RHO) for pair in _pairs(plain)),
        count_of("pair", experiment),
    )
    yield _line("small", experiment, seen, SMALL_RHO, drift=False)
    wiring = switches_in(experiment, untestable=False)
    yield _line("switch", experiment, wiring, 0.0, drift=experiment == "walk")
    for item in switches_in(experiment, untestable=True):
        yield _line("untestable", experiment, (item,), 0.0, drift=experiment == "walk")
    few = ((), *((item.key,) for item in plain))
    yield Line(
        tuple(Cell("underpowered", experiment, hidden, 1.0) for hidden in few),
        count_of("underpowered", experiment),
    )


def _line(kind: Kind, experiment: str, items: Sequence[Injection], rho: float, drift: bool) -> Line:
    cells = tuple(Cell(kind, experiment, (item.key,), rho, drift) for item in items)
    return Line(cells, count_of(kind, experiment))


def count_of(kind: Kind, experiment: str) -> int:
    """Trials of a line in a full run."""
    return COUNTS[kind] // (2 if experiment in DEAR and kind != "single" else 1)


def left_out_with(item: Injection) -> str:
    """The names that must be taken out with an effect: a cubic is no wrong name for a curve."""
    curve = "nonlinearity" in item.right
    return " ".join(dict.fromkeys((*item.right, *(CURVES if curve else ()))))


def _pairs(seen: Sequence[Injection]) -> Iterator[tuple[str, str]]:
    """Each effect with the next one of another name."""
    for i, first in enumerate(seen):
        for second in (*seen[i + 1 :], *seen[:i]):
            if not set(first.right) & set(second.right):
                yield first.key, second.key
                break
