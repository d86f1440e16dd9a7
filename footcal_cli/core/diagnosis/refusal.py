"""A candidate that chance does not explain and that was not accepted all the same."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum, auto

from footcal_cli.core.inference.problem import Signature


class Why(Enum):
    """What stood against it."""

    IMPOSSIBLE = auto()
    """Its size lies outside what is physically possible."""
    LITTLE = auto()
    """It removes less of the error than a cause must."""
    FORM = auto()
    """It removes so little beside the causes before it that it may be an error of their form."""
    UNSURE = auto()
    """That it removes anything on held-out blocks may be chance."""
    SMALL = auto()
    """Its size does not matter."""
    SUPERSEDED = auto()
    """The causes that were accepted after it explain the same."""


@dataclass(frozen=True)
class Refusal:
    """One candidate and what stood against it.

    Parameters
    ----------
    signature, size
        What it would have been, in the signature's unit.
    share
        Share of the squared error that it removes on blocks it was not fitted to.
    limit
        The least share (LITTLE), the least part of what the causes before it removed (FORM) or the
        largest p (UNSURE) that is asked.
    p
        Of its gain on held-out blocks (UNSURE).
    """

    signature: Signature
    why: Why
    size: float = float("nan")
    share: float = float("nan")
    limit: float = float("nan")
    p: float = float("nan")
