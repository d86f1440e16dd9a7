"""A plain list of wrong names and misses by class, for development seeds only.

``python -m tests.blind.misses --out FOLDER --ledger FOLDER`` after a development run. It opens no
sealed ledger: what is read here may be learnt from.
"""

from __future__ import annotations

import argparse
import re
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


def sizes_of(score: Score) -> str:
    """Sizes of what was said."""
    verdict = score.verdict
    given = sorted(verdict.names | frozenset().union(*verdict.rivals, frozenset()))
    sizes = verdict.sizes or {}
    known = [(name, *sizes[name]) for name in given if name in sizes]
    return "; ".join(f"{n} = {size:.3g} [{low:.3g}, {high:.3g}]" for n, size, low, high in known)


def misses_page(scores: Sequence[Score]) -> str:
    """Every trial that was not answered rightly, as a page: hidden, said, and footcal's reason."""
    lines = [
        "# Misses of the blind bench\n",
        "Trials of [the blind bench](blind_bench.md) that were not answered rightly, by class. "
        "*Reason*: what footcal's table says of the hidden effect. This page is generated.\n",
    ]
    classes = sorted({classes_of(s) for s in scores} - {""})
    for name in classes:
        mine = sorted((s for s in scores if classes_of(s) == name), key=_order)
        lines += [f"## {name[2:].capitalize()} ({len(mine)})\n"]
        lines += [
            "| experiment | trial | hidden | ρ | said | reason |",
            "|---|---|---|---|---|---|",
        ]
        lines += [f"| {' | '.join(_row(s))} |" for s in mine]
        lines += [""]
    return "\n".join(lines).rstrip() + "\n"


def _row(score: Score) -> tuple[str, ...]:
    truth = score.truth
    keys = " and ".join(str(e["key"]) for e in truth["effects"]) or "nothing"
    without = f" (without {truth['left_out']})" if truth["left_out"] else ""
    return (
        score.group,
        str(truth["kind"]),
        keys + without,
        f"{truth['rho']:g}" if truth["rho"] else "–",
        answer_of(score),
        reason_of(score) or "–",
    )


def answer_of(score: Score) -> str:
    """Verdict, names and rival sets in one line."""
    verdict = score.verdict
    said = verdict.verdict
    if verdict.names:
        said += ": " + ", ".join(sorted(verdict.names))
    return said + "".join(" {" + ", ".join(sorted(group)) + "}" for group in verdict.rivals)


def reason_of(score: Score) -> str:
    """What footcal's own table says of the hidden effects."""
    if score.verdict.said:
        return re.sub(r"/\S+/", "", " ".join(score.verdict.said.split()))[-160:]
    reasons = score.verdict.reasons or {}
    statuses = score.verdict.statuses or {}
    found = []
    for effect in score.truth["effects"]:
        for name in effect["right"][:1]:
            pairs = zip(statuses.get(name, ()), reasons.get(name, ()), strict=True)
            told = [f"{status}: {reason}" if reason else status for status, reason in pairs]
            found.append(f"{name} {Counter(told).most_common(1)[0][0] if told else 'no row'}")
    return "; ".join(found).replace("|", "/")


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
    said = answer_of(score) + (f" ({verdict.said.strip()[-200:]})" if verdict.said else "")
    facts = {k: truth["facts"][k] for k in ("noise", "engine") if k in truth.get("facts", {})}
    keys = tuple(str(e["key"]) for e in truth["effects"])
    again = (
        f"make_trial(Cell({truth['kind']!r}, {truth['experiment']!r}, {keys}, {truth['rho']:g}, "
        f"{bool(truth['drift'])}, {truth['left_out']!r}), {truth['seed']}, folder)"
    )
    return [
        f"- {score.group} / {truth['kind']}: {hidden or 'nothing'}{rho}{without} -> {said}",
        f"    {facts}; {reason_of(score)}; {sizes_of(score)}",
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
