"""What an entry of the catalogue is."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tests.blind.world import Rng, World

Act = Callable[[World, float, Rng], World]
Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class Injection:
    """One way to distort a world.

    Parameters
    ----------
    key
        ``effect/implementation``.
    names
        Right answers, the best first, separated by spaces; none for an unseen effect.
    where
        Experiments it is hidden in, separated by spaces.
    act
        ``(world, size, rng) -> world``; the same rng state gives the same place and shape.
    guess
        First size tried, in `unit`.
    parameter
        The table's parameter whose value `size` is, empty where sizes cannot be compared. Of a
        hysteresis the loop at the recorded loads is compared (`tests.blind.loops`), whatever its
        form: an asymptote that no load reached is no size.
    alias
        In these experiments no data of that kind tells it from other names (METHODS.md): a rival
        set is the right answer, and a lone name is right by luck only.
    foreign
        Not footcal's implementation.
    most
        Largest size met in practice; a world that needs more for its ρ is drawn again.
    switch
        It is there or not: its size is `guess` and no ρ is set.
    untestable
        No data of its experiments can show it (METHODS.md): the right answer is *not testable*.
    """

    key: str
    names: str
    where: str
    act: Act
    guess: float
    unit: str = ""
    parameter: str = ""
    alias: tuple[str, ...] = ()
    foreign: bool = True
    switch: bool = False
    untestable: bool = False
    signed: bool = True
    most: float = np.inf

    @property
    def right(self) -> tuple[str, ...]:
        """Names that are right answers."""
        return tuple(self.names.split())

    @property
    def experiments(self) -> tuple[str, ...]:
        """Where it is hidden."""
        return tuple(self.where.split())
