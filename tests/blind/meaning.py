"""What the measured figures mean for somebody with a robot and a log: sentences and one table."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from tests.blind.scoring import Score, Share

Flag = Callable[[Score], bool]
ANSWERABLE = ("single", "alias", "pair")


def meaning(scores: Sequence[Score]) -> list[str]:
    """Paragraphs, each from counts of this run."""
    return [
        _silence(scores),
        _trust(scores),
        _power(scores),
        _limits(scores),
        by_experiment(scores),
    ]


def _silence(scores: Sequence[Score]) -> str:
    nulls = [s for s in scores if s.truth["kind"] == "null"]
    if not nulls:
        return "No clean logs were judged.\n"
    named = Share.of(s.wrong for s in nulls)
    alarms = Share.of(s.alarm for s in nulls)
    return (
        f"**A clean log.** Of {named.trials} logs with nothing wrong in them, {named.hits} got a "
        f"name and {alarms.hits} any alarm at all: with 95 % confidence fewer than "
        f"{100 * named.upper():.1f} % and {100 * alarms.upper():.1f} % do.\n"
    )


def _trust(scores: Sequence[Score]) -> str:
    """How often a name that was given is right, wherever one was given."""
    given = [s for s in scores if s.verdict.names]
    known = [s for s in given if s.truth["kind"] in ANSWERABLE]
    foreign = [s for s in given if s.truth["kind"] in ("unseen", "left_out")]
    right, astray = Share.of(not s.wrong for s in known), Share.of(s.wrong for s in foreign)
    strangers = sum(s.truth["kind"] in ("unseen", "left_out") for s in scores)
    rivals = [s for s in scores if s.truth["kind"] in ANSWERABLE and _only_rivals(s)]
    held = Share.of(s.right for s in rivals)
    return (
        f"**A name.** Where a cause of the table was hidden and certain names were given, they "
        f"were right in {right}. Of {strangers} logs with a cause that footcal does not know, "
        f"{astray.hits} got a certain name all the same. **Rivals.** Where footcal answered with "
        f"a set of rivals and no certain name, the set held the cause in {held}.\n"
    )


def _only_rivals(score: Score) -> bool:
    return score.verdict.verdict == "ambiguous" and not score.verdict.names


def _power(scores: Sequence[Score]) -> str:
    words = []
    for rho, size in ((0.3, "a third of"), (0.5, "half"), (1.0, "as large as")):
        mine = [s for s in scores if s.truth["kind"] in ("single", "alias")]
        share = Share.of(s.right for s in mine if s.truth["rho"] == rho and s.matters)
        if share.trials:
            words.append(f"{size} the noise in {100 * share.value:.0f} %")
    return (
        "**One cause.** After calibration has absorbed what it can, a cause that leaves an error "
        f"{', '.join(words)} of the logs is named, alone or among its rivals; the others mostly "
        "end as *none* or *unknown* (figure of what was said).\n"
    )


def _limits(scores: Sequence[Score]) -> str:
    pairs = [s for s in scores if s.truth["kind"] == "pair"]
    unseen = [s for s in scores if s.truth["kind"] == "unseen"]
    both, flagged = Share.of(s.right for s in pairs), Share.of(s.right for s in unseen)
    return (
        f"**Two causes at once** are both answered in {both}. **A cause outside the table** is "
        f"flagged, without a wrong name, in {flagged}: silence is no proof that nothing is "
        "wrong.\n"
    )


def by_experiment(scores: Sequence[Score]) -> str:
    """One row per experiment: what to expect of it."""
    head = (
        "| experiment | right answer, ρ 1 | certain names that are right | clean logs left alone |"
    )
    rows = [head, "|---|---|---|---|"]
    for group in dict.fromkeys(s.group for s in sorted(scores, key=lambda s: s.group)):
        mine = [s for s in scores if s.group == group]
        found = Share.of(
            s.right
            for s in mine
            if s.truth["kind"] in ("single", "alias") and s.truth["rho"] == 1.0 and s.matters
        )
        sure = Share.of(not s.wrong for s in mine if s.verdict.names)
        quiet = Share.of(not s.alarm for s in mine if s.truth["kind"] == "null")
        rows.append(f"| {group} | {found} | {sure} | {quiet} |")
    return "\n".join(rows) + "\n"
