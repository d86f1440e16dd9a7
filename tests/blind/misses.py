"""A plain list of wrong names and misses by class, for development seeds only.

``python -m tests.blind.misses --out FOLDER --ledger FOLDER`` after a development run. It opens no
sealed ledger: what is read here may be learnt from.
"""

from __future__ import annotations

import argparse
import sys
from collections import Counter, defaultdict
from collections.abc import Sequence
from pathlib import Path

from tests.blind.bench import Bench, opened
from tests.blind.demands import DEMANDS
from tests.blind.ledger import open_ledger
from tests.blind.scoring import Score


def classes_of(score: Score) -> str:
    """Which kind of failure a trial is, empty for a right answer."""
    verdict, kind = score.verdict, str(score.truth["kind"])
    if verdict.verdict == "error":
        return "1 error"
    if score.wrong:
        return "2 wrong name"
    if score.right:
        return ""
    if kind == "null":
        return "3 false alarm"
    if verdict.verdict == "none":
        return "4 missed: none"
    if verdict.rivals and verdict.verdict not in ("unknown", "none"):
        return "5 rivals without the truth, or with a stranger set beside it"
    return "6 " + verdict.verdict + ", not the truth"


def guess_of(score: Score) -> str:
    """One line on what the numbers point at."""
    truth, verdict = score.truth, score.verdict
    statuses = verdict.statuses or {}
    reasons = []
    for effect in truth["effects"]:
        for name in effect["right"][:1]:
            found = Counter(statuses.get(name, ()))
            said = ", ".join(f"{status} ×{count}" for status, count in found.items())
            reasons.append(f"{name}: {said or 'no row in the table'}")
    given = sorted(verdict.names | frozenset().union(*verdict.rivals, frozenset()))
    for name in given:
        if name in (verdict.sizes or {}):
            size, low, high = (verdict.sizes or {})[name]
            reasons.append(f"{name} = {size:.3g} [{low:.3g}, {high:.3g}]")
    return "; ".join(reasons)


def listing(scores: Sequence[Score]) -> str:
    """Every failure by class and experiment, the demands on top."""
    lines = ["demands on these development trials:"]
    for demand in DEMANDS:
        if demand.share(scores).trials:
            flag = "  " if demand.met(scores) else "! "
            lines.append(f"{flag}{demand.trial} | {demand.score} | {demand.asked()} | "
                         f"{demand.share(scores)}")  # fmt: skip
    by_class: defaultdict[str, list[Score]] = defaultdict(list)
    for score in scores:
        if classes_of(score):
            by_class[classes_of(score)].append(score)
    for name in sorted(by_class):
        lines += ["", f"== {name[2:]} ({len(by_class[name])})"]
        for score in sorted(by_class[name], key=_order):
            lines += _entry(score)
    return "\n".join(lines) + "\n"


def _order(score: Score) -> tuple[str, str, str]:
    keys = [str(effect["key"]) for effect in score.truth["effects"]]
    return score.group, str(score.truth["kind"]), " ".join(keys)


def _entry(score: Score) -> list[str]:
    truth, verdict = score.truth, score.verdict
    hidden = " + ".join(
        f"{e['key']} {e['size']:.3g} {e['unit']}".rstrip() for e in truth["effects"]
    )
    rho = f" rho {truth['rho']:g}" if truth["rho"] else ""
    without = f" (without {truth['left_out']})" if truth["left_out"] else ""
    said = verdict.verdict + (f" ({verdict.said.strip()[-200:]})" if verdict.said else "")
    if verdict.names:
        said += " names=" + ",".join(sorted(verdict.names))
    said += "".join(" {" + ",".join(sorted(group)) + "}" for group in verdict.rivals)
    facts = {k: truth["facts"][k] for k in ("noise", "engine") if k in truth.get("facts", {})}
    keys = tuple(str(e["key"]) for e in truth["effects"])
    again = (
        f"make_trial(Cell({truth['kind']!r}, {truth['experiment']!r}, {keys}, {truth['rho']:g}, "
        f"{bool(truth['drift'])}, {truth['left_out']!r}), {truth['seed']}, folder)"
    )
    return [
        f"- {score.group} / {truth['kind']}: {hidden or 'nothing'}{rho}{without} -> {said}",
        f"    {facts}; {guess_of(score)}",
        f"    {again}",
    ]


def run(arguments: list[str] | None = None) -> None:
    """Print the list."""
    parser = argparse.ArgumentParser(prog="python -m tests.blind.misses", description=__doc__)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--ledger", type=Path, required=True)
    given = parser.parse_args(arguments)
    scores, _ = opened(Bench(given.out, open_ledger(given.ledger, "development")))
    sys.stdout.write(listing(scores))


if __name__ == "__main__":
    run()
