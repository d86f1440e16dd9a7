"""What the bench must show, and how each figure is counted."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from tests.blind.scoring import Score, Share

Chosen = Callable[[Score], bool]
Flag = Callable[[Score], bool]


@dataclass(frozen=True)
class Demand:
    """One required figure.

    Parameters
    ----------
    trial, score
        Words for the page.
    chosen, flag
        Which trials count, and what is counted in them.
    bound
        The share asked for.
    sense
        ``at_least`` or ``at_most``.
    reach
        Which of the oracle's figures (`tests.blind.oracle`) bounds it from above, if any.
    """

    trial: str
    score: str
    chosen: Chosen
    flag: Flag
    bound: float
    sense: Literal["at_least", "at_most"] = "at_least"
    reach: Literal["exact", "right", ""] = ""

    def share(self, scores: Sequence[Score]) -> Share:
        """The figure as measured."""
        return Share.of(self.flag(s) for s in scores if self.chosen(s))

    def reachable(self, scores: Sequence[Score]) -> float:
        """Mean of what an oracle reaches in these trials; NaN where no ledger says."""
        known = [s.truth["limit"] for s in scores if self.chosen(s) and s.truth.get("limit")]
        if not self.reach or not known:
            return float("nan")
        return float(np.mean([limit[self.reach] for limit in known]))

    def met(self, scores: Sequence[Score]) -> bool:
        """Whether the measured share meets the bound (the point estimate, as the issue asks)."""
        value = self.share(scores).value
        return value >= self.bound if self.sense == "at_least" else value <= self.bound

    def asked(self) -> str:
        """The bound in words."""
        return f"{'≥' if self.sense == 'at_least' else '≤'} {100 * self.bound:g} %"

    def against(self, scores: Sequence[Score], most: int = 4) -> str:
        """Which trials went the other way: what was hidden and what was said."""
        bad = [
            s for s in scores if self.chosen(s) and self.flag(s) is not (self.sense == "at_least")
        ]
        said = Counter(f"{_hidden(s)} → {_said(s)}" for s in bad)
        parts = [f"{what} ({count})" for what, count in said.most_common(most)]
        rest = len(bad) - sum(count for _, count in said.most_common(most))
        return "; ".join(parts) + (f"; {rest} others" if rest else "")


def _hidden(score: Score) -> str:
    keys = [str(effect["key"]) for effect in score.truth["effects"]]
    rho = score.truth["rho"]
    return (" and ".join(keys) or "nothing") + (f" at ρ {rho:g}" if keys and rho else "")


def _said(score: Score) -> str:
    verdict = score.verdict
    names = sorted(verdict.names) or sorted(set().union(*verdict.rivals))
    return verdict.verdict + (f" {{{', '.join(names[:3])}}}" if names else "")


def _kind(kind: str) -> Chosen:
    return lambda s: s.truth["kind"] == kind


def _single(rho: float) -> Chosen:
    """One effect that matters and has no alias in its experiment."""
    return lambda s: s.truth["kind"] == "single" and s.truth["rho"] == rho and s.matters


def _one(rho: float) -> Chosen:
    """One effect that matters, alone in its look or not."""
    return lambda s: s.truth["kind"] in ("single", "alias") and s.truth["rho"] == rho and s.matters


def _unseen(rho: float) -> Chosen:
    return lambda s: s.truth["kind"] == "unseen" and s.truth["rho"] == rho


def _foreign(s: Score) -> bool:
    return _one(1.0)(s) and bool(s.truth["effects"][0]["foreign"])


def _sized(*, foreign: bool) -> Chosen:
    """A foreign implementation is another model: its size is comparable, its interval less so."""
    return lambda s: s.covered is not None and s.truth["effects"][0]["foreign"] is foreign


def _both_rivals(s: Score) -> bool:
    """The rival set holds the effect and at least one of its aliases."""
    effect = s.truth["effects"][0]
    others = set(effect["alias"]) - set(effect["right"])
    return any(set(effect["right"]) & group and others & group for group in s.verdict.rivals)


EXACT = {0.3: 0.60, 0.5: 0.85, 1.0: 0.95}
CLASS = {0.3: 0.60, 0.5: 0.75, 1.0: 0.88}
RIGHT = {0.3: 0.75, 0.5: 0.92, 1.0: 0.98}

DEMANDS: tuple[Demand, ...] = (
    Demand("null", "false name", _kind("null"), lambda s: s.wrong, 0.01, "at_most"),
    Demand("null", "any alarm", _kind("null"), lambda s: s.alarm, 0.03, "at_most"),
    *(
        Demand(f"single, ρ {rho:g}", "exact name", _single(rho), lambda s: s.exact, bound,
               reach="exact")
        for rho, bound in EXACT.items()
    ),
    *(
        Demand(f"single, ρ {rho:g}", "exact class", _single(rho), lambda s: s.of_one_class, bound)
        for rho, bound in CLASS.items()
    ),
    *(
        Demand(f"single, ρ {rho:g}", "right answer", _one(rho), lambda s: s.right, bound,
               reach="right")
        for rho, bound in RIGHT.items()
    ),
    Demand("single, all ρ", "confident wrong name",
           lambda s: s.truth["kind"] in ("single", "alias"), lambda s: s.wrong, 0.01, "at_most"),
    Demand("single, named", "95 % interval covers the size", _sized(foreign=False),
           lambda s: bool(s.covered), 0.90),
    Demand("single, foreign, named", "95 % interval covers the size", _sized(foreign=True),
           lambda s: bool(s.covered), 0.90),
    Demand("single, named", "95 % interval covers the gain",
           lambda s: s.gain_covered is not None, lambda s: bool(s.gain_covered), 0.90),
    Demand("two effects, ρ 0.6", "both named", _kind("pair"), lambda s: s.exact, 0.75,
           reach="exact"),
    Demand("two effects, ρ 0.6", "both classes named", _kind("pair"), lambda s: s.of_one_class,
           0.65),
    Demand("two effects, ρ 0.6", "right answer", _kind("pair"), lambda s: s.right, 0.90,
           reach="right"),
    Demand("two effects, ρ 0.6", "wrong extra name", _kind("pair"), lambda s: s.wrong, 0.02,
           "at_most"),
    Demand("unseen, ρ 0.6", "unknown or flagged", _unseen(0.6), lambda s: s.right, 0.90),
    Demand("unseen, ρ 1", "unknown or flagged", _unseen(1.0), lambda s: s.right, 0.98),
    Demand("unseen, all ρ", "confident wrong name", _kind("unseen"), lambda s: s.wrong, 0.03,
           "at_most"),
    Demand("left out of the library, ρ 1", "confident wrong name", _kind("left_out"),
           lambda s: s.wrong, 0.03, "at_most"),
    Demand("designed alias, ρ ≥ 0.5", "both in the rival set", _kind("alias"), _both_rivals, 0.95,
           reach="right"),
    Demand("designed alias", "resolved by the proposed experiment",
           lambda s: s.resolved is not None, lambda s: bool(s.resolved), 0.90),
    Demand("wiring", "named or bad-data", _kind("switch"), lambda s: s.right, 0.98),
    Demand("hidden in the calibration itself", "not testable, no name", _kind("untestable"),
           lambda s: s.right, 0.95),
    Demand("too little data", "says underpowered", _kind("underpowered"), lambda s: s.right, 1.0),
    Demand("too little data", "false name", _kind("underpowered"), lambda s: s.wrong, 0.0,
           "at_most"),
    Demand("below the size that matters", "named all the same", _kind("small"), lambda s: s.wrong,
           0.02, "at_most"),
    Demand("foreign implementation, ρ ≥ 1", "right answer", _foreign, lambda s: s.right, 0.90,
           reach="right"),
)  # fmt: skip
"""In the order of issue 8's table."""
