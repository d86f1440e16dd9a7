"""What a verdict is worth once the ledger is open."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import stats

from tests.blind.classes import classes_of
from tests.blind.world import Array

NAMING = ("named", "named+unknown")
QUIET = ("none", "underpowered")
FLAGGING = ("unknown", "ambiguous", "named+unknown", "bad-data")


@dataclass(frozen=True)
class Verdict:
    """What a diagnosis said, read from its ``diagnosis.json``.

    Parameters
    ----------
    verdict
        One of DIAGNOSIS's seven, or ``error``.
    names
        Effects it named (not those of a rival set).
    rivals
        Sets of effects it could not tell apart.
    sizes
        Effect -> (size, lowest, highest) of the 95 % interval.
    statuses
        Effect -> statuses of its rows.
    gains
        Effect -> (quantity, lowest, highest) of the held-out gain's 95 % interval.
    confidence
        Larger is surer: −log10 of the largest p of the named causes.
    said
        What the command said where it made no diagnosis.
    reasons
        Effect -> why its rows have their statuses.
    survivors
        Rivals of the log before that it says are left.
    """

    verdict: str
    names: frozenset[str] = frozenset()
    rivals: tuple[frozenset[str], ...] = ()
    sizes: Mapping[str, tuple[float, float, float]] | None = None
    statuses: Mapping[str, tuple[str, ...]] | None = None
    gains: Mapping[str, tuple[str, float, float]] | None = None
    confidence: float = 0.0
    said: str = ""
    reasons: Mapping[str, tuple[str, ...]] | None = None
    survivors: frozenset[str] = frozenset()

    @classmethod
    def read(cls, record: Mapping[str, Any]) -> Verdict:
        """From the content of ``diagnosis.json``; tolerant of what it does not need."""
        rivals = tuple(frozenset(_names(group)) for group in record.get("rivals", ()))
        causes = list(record.get("causes", ()))
        verdict = str(record["verdict"])
        together = frozenset().union(*rivals) if rivals else frozenset()
        named = frozenset(str(cause["effect"]) for cause in causes)
        statuses: dict[str, tuple[str, ...]] = {}
        reasons: dict[str, tuple[str, ...]] = {}
        for row in record.get("effects", ()):
            name = str(row["effect"])
            statuses[name] = (*statuses.get(name, ()), str(row["status"]))
            reasons[name] = (*reasons.get(name, ()), str(row.get("reason", "")))
        sizes = {
            str(c["effect"]): (float(c["size"]), float(c["ci95"][0]), float(c["ci95"][1]))
            for c in causes
            if c.get("ci95") is not None and c.get("size") is not None
        }
        claims = {str(c["effect"]): c["held_out_gain"] for c in causes if c.get("held_out_gain")}
        gains = {
            name: (str(claim["quantity"]), float(claim["ci95"][0]), float(claim["ci95"][1]))
            for name, claim in claims.items()
            if claim.get("ci95") is not None
        }
        ps = [float(c["p"]) for c in causes if c.get("p") is not None]
        return cls(
            verdict=verdict,
            # an unknown may come with candidates; they are not given as names
            names=(named - together) if verdict in (*NAMING, "ambiguous") else frozenset(),
            rivals=rivals,
            sizes=sizes,
            statuses=statuses,
            gains=gains,
            confidence=float(-np.log10(max(max(ps), 1e-12))) if ps else 0.0,
            said=str(record.get("said", "")),
            reasons=reasons,
            survivors=frozenset(record.get("survivors", ())),
        )


def _names(group: Iterable[Any]) -> Iterable[str]:
    return (str(item["effect"]) if isinstance(item, Mapping) else str(item) for item in group)


@dataclass(frozen=True)
class Score:
    """One trial, judged.

    Parameters
    ----------
    exact
        Every hidden effect named, nothing else named.
    right
        As exact, but a rival set that holds the effect counts too; for trials without a name to
        find, the right kind of silence (see `judge`).
    wrong
        A name that is not right was given with confidence.
    alarm
        Anything but ``none`` or ``underpowered``.
    column
        Column of the confusion matrix.
    covered
        Whether the 95 % interval of a comparable size held the truth; None where not comparable.
    gain_covered
        The same of the held-out gain.
    matters
        Whether some hidden effect is larger than the smallest error that matters.
    resolved
        Whether a designed alias was told apart after the proposed experiment; None where none was
        made.
    """

    truth: Mapping[str, Any]
    verdict: Verdict
    exact: bool
    right: bool
    wrong: bool
    alarm: bool
    column: str
    covered: bool | None
    gain_covered: bool | None = None
    matters: bool = True
    resolved: bool | None = None

    @property
    def group(self) -> str:
        """The column of a trial: its experiment, drifting walks apart."""
        drifting = self.truth["experiment"] == "walk" and self.truth.get("drift")
        return "walk, drifting" if drifting else str(self.truth["experiment"])

    @property
    def of_one_class(self) -> bool:
        """Every hidden effect is named, alone or by rivals that one remedy serves."""
        alone = self.right and self.alarm and all(classes_of(g) == 1 for g in self.verdict.rivals)
        return self.exact or alone

    @property
    def row(self) -> str:
        """Row of the confusion matrix: what was hidden."""
        kind, effects = str(self.truth["kind"]), self.truth["effects"]
        if not effects:
            return "none"
        if kind == "left_out":
            return "left out"
        if kind in ("pair", "underpowered"):
            return "two effects" if kind == "pair" else "too little data"
        return str(effects[0]["right"][0]) if effects[0]["right"] else "unseen"


def judge(truth: Mapping[str, Any], verdict: Verdict) -> Score:
    """Judge a verdict.

    A rival set that holds the effect is a right answer; a name given beside it must be right too.
    An effect smaller than what matters may be named or not. Otherwise right is: for a null,
    ``none`` (or ``underpowered``); unseen or left out, any flag without a wrong name; wiring, a
    name or ``bad-data``; untestable, no name and the status ``not_testable``; too little data,
    ``underpowered``; below the size that matters, no name.
    """
    kind = str(truth["kind"])
    hidden = [frozenset(effect["right"]) for effect in truth["effects"]]
    if kind == "left_out":
        hidden = []
    allowed = frozenset().union(*hidden) if hidden else frozenset()
    wrong = bool(verdict.names - allowed)
    alarm = verdict.verdict not in QUIET
    named = [bool(names & verdict.names) for names in hidden]
    held = [any(names & group for group in verdict.rivals) for names in hidden]
    found = bool(hidden) and all(n or h for n, h in zip(named, held, strict=True))
    # a rival set that holds nothing of what was hidden is a wrong suspicion, though not a name
    astray = any(not group & allowed for group in verdict.rivals)
    exact = bool(hidden) and all(named) and not wrong and not astray
    flagged = verdict.verdict in FLAGGING
    sizes = [effect.get("matters") for effect in truth["effects"]]
    matters = not sizes or any(size is None or size >= 1.0 for size in sizes)
    answered = found and not wrong and not astray
    right = {
        "null": not alarm,
        "unseen": flagged and not wrong,
        "left_out": flagged and not wrong,
        "switch": (found or verdict.verdict == "bad-data") and not wrong,
        "untestable": not verdict.names and _not_testable(hidden, verdict),
        "underpowered": verdict.verdict == "underpowered" and not verdict.names,
        "small": not verdict.names,
    }.get(kind, answered or (not matters and not alarm))
    if kind in ("null", "underpowered", "small", "untestable"):
        wrong = bool(verdict.names)
    return Score(
        truth,
        verdict,
        exact,
        right,
        wrong,
        alarm,
        _column(verdict, allowed, held),
        _covered(truth, verdict),
        _gain_covered(truth, verdict),
        matters,
        truth.get("resolved"),
    )


def judge_followup(truth: Mapping[str, Any], first: Verdict, second: Verdict) -> bool:
    """Whether two experiments together leave the hidden effect alone.

    Of the first rival set those survive that the second answer says are left; where it says
    nothing of them, those that it names, else those that it could not rule out.
    """
    right = frozenset(truth["effects"][0]["right"])
    suspected = next((g for g in first.rivals if g & right), frozenset())
    named = second.names | frozenset().union(*second.rivals, frozenset())
    statuses = second.statuses or {}
    open_still = {n for n in suspected if "absent" not in statuses.get(n, ())}
    survivors = suspected & (second.survivors or named) or open_still
    return bool(survivors) and survivors <= right


def _not_testable(hidden: Sequence[frozenset[str]], verdict: Verdict) -> bool:
    statuses = verdict.statuses or {}
    return all(any("not_testable" in statuses.get(name, ()) for name in names) for names in hidden)


def _column(verdict: Verdict, allowed: frozenset[str], held: Sequence[bool]) -> str:
    if verdict.verdict in NAMING and verdict.names:
        what = "right name" if verdict.names <= allowed else "wrong name"
        return what + (" + unknown" if verdict.verdict == "named+unknown" else "")
    if verdict.rivals and verdict.verdict not in ("unknown", "none", "underpowered", "bad-data"):
        return "rivals with it" if any(held) else "rivals without it"
    return verdict.verdict


def _covered(truth: Mapping[str, Any], verdict: Verdict) -> bool | None:
    """Whether the interval holds the size, where exactly one comparable effect was named."""
    if len(truth["effects"]) != 1 or not verdict.sizes:
        return None
    effect = truth["effects"][0]
    if not effect["parameter"] or not effect["right"] or effect["right"][0] not in verdict.sizes:
        return None
    _, low, high = verdict.sizes[effect["right"][0]]
    # the size of a belief or an operator may be counted with the other sign
    true = effect["size"] if effect.get("stated") is None else effect["stated"]
    return any(low <= sign * true <= high for sign in (1.0, -1.0))


def _gain_covered(truth: Mapping[str, Any], verdict: Verdict) -> bool | None:
    """Whether the interval holds the gain that removing the one hidden effect must bring."""
    if len(truth["effects"]) != 1 or not verdict.gains or len(verdict.names) != 1:
        return None
    name = next(iter(verdict.names))
    if name not in truth["effects"][0]["right"] or name not in verdict.gains:
        return None
    quantity, low, high = verdict.gains[name]
    gain = truth.get("gain", {}).get(quantity)
    return None if gain is None else bool(low <= gain <= high)


@dataclass(frozen=True)
class Share:
    """How often something happened, with its uncertainty."""

    hits: int
    trials: int

    @classmethod
    def of(cls, flags: Iterable[bool]) -> Share:
        """Count flags."""
        values = list(flags)
        return cls(sum(values), len(values))

    @property
    def value(self) -> float:
        """Hits over trials; NaN without trials."""
        return self.hits / self.trials if self.trials else float("nan")

    def wilson(self) -> tuple[float, float]:
        """Two-sided 95 % interval after Wilson, J. Am. Stat. Assoc. 22 (1927)."""
        if not self.trials:
            return 0.0, 1.0
        z, n, p = 1.959964, self.trials, self.value
        centre = (p + z**2 / (2 * n)) / (1 + z**2 / n)
        half = z / (1 + z**2 / n) * np.sqrt(p * (1 - p) / n + z**2 / (4 * n**2))
        return max(float(centre - half), 0.0), min(float(centre + half), 1.0)

    def upper(self) -> float:
        """One-sided 95 % upper bound after Clopper and Pearson, Biometrika 26 (1934)."""
        if not self.trials or self.hits == self.trials:
            return 1.0
        return float(stats.beta.ppf(0.95, self.hits + 1, self.trials - self.hits))

    def __str__(self) -> str:
        if not self.trials:
            return "–"
        low, high = self.wilson()
        bounds = f"[{100 * low:.0f}, {100 * high:.0f}]"
        return f"{100 * self.value:.0f} % {bounds} ({self.hits}/{self.trials})"


def rho_at_power(scores: Sequence[Score], power: float = 0.8) -> tuple[float, str]:
    """ρ at which the right answer comes with a given power, by a monotone curve through the shares.

    Returns the ρ and how it was found: ``interpolated``, ``below`` the smallest or ``above`` the
    largest ρ tried.
    """
    rhos = sorted({float(s.truth["rho"]) for s in scores})
    shares = [Share.of(s.right for s in scores if s.truth["rho"] == rho) for rho in rhos]
    # pool adjacent violators: power does not fall as the effect grows
    level = _isotonic([s.value for s in shares], [s.trials for s in shares])
    if level[0] >= power:
        return rhos[0], "below"
    if level[-1] < power:
        return rhos[-1], "above"
    at = int(np.argmax(np.asarray(level) >= power))
    share = (power - level[at - 1]) / (level[at] - level[at - 1])
    logs = np.log(rhos)
    return float(np.exp(logs[at - 1] + share * (logs[at] - logs[at - 1]))), "interpolated"


def _isotonic(values: Sequence[float], weights: Sequence[int]) -> list[float]:
    blocks: list[tuple[float, float, int]] = []
    for value, weight in zip(values, weights, strict=True):
        blocks.append((value, float(weight), 1))
        while len(blocks) > 1 and blocks[-2][0] > blocks[-1][0]:
            (a, n, i), (b, m, j) = blocks[-2], blocks[-1]
            blocks[-2:] = [((a * n + b * m) / (n + m), n + m, i + j)]
    return [value for value, _, count in blocks for _ in range(count)]


def risk_coverage(scores: Sequence[Score], risked: Sequence[Score]) -> tuple[Array, Array]:
    """Share of some trials given any name, and of others a wrong one, as less sure names count.

    The same least confidence holds for both; it falls along the arrays.
    """
    named = np.array([s.verdict.confidence for s in scores if s.verdict.names])
    wrong = np.array([s.verdict.confidence for s in risked if s.wrong])
    least = np.unique(np.concatenate([named, wrong]))[::-1, None]
    coverage, risk = (np.sum(one >= least, axis=1) for one in (named, wrong))
    return coverage / max(len(scores), 1), risk / max(len(risked), 1)
