"""``docs/blind_bench.md``: every demanded figure beside the measured one."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np

from tests.blind.demands import DEMANDS
from tests.blind.figures import draw_confusion, draw_limits, draw_power, draw_risk
from tests.blind.hidden import CATALOGUE
from tests.blind.meaning import meaning
from tests.blind.misses import misses_page
from tests.blind.scoring import Score, Share, rho_at_power

GROUPS = ("weights", "placements", "walk", "walk, drifting", "hang", "pose", "stand")
INTRO = """# The blind bench

Effects are hidden in logs, `footcal diagnose` must find them, and what it said is counted here. It
sees logs, recipe and the calibration of the ordinary command; the truth was sealed before and
opened after. `make blind` repeats it. This page is generated.

"""
READING = """**ρ** is the RMS of what an effect leaves after the calibration has been refitted (in a
drifting walk: followed), over the RMS of the noise, on the outputs that it touches; measured by the
bench's own projection, not by footcal's. *Exact*: every hidden effect named and nothing else.
*Exact class*: as exact, but rivals that one remedy serves count as one name (curves of a cell's own
load; level and lever of the body; creep; times of streams; what changes the sum; turned axes).
*Right answer*: a rival set that holds it counts too. *Designed alias*: no data of that experiment
distinguishes it from another cause (|cos| > 0.95 by the same projection). Brackets are 95 %
intervals (Wilson); upper bounds are one-sided 95 % (Clopper–Pearson). Columns of experiments:
per cent (trials). Bold: demanded and not reached.
"""
LIMITS = """## What could be reached at all

**An oracle reaches** is the most that any diagnosis could reach on these trials if it may give a
wrong name in at most one of a hundred. The bench computes it when it hides an effect, from the
truth. The oracle knows what footcal must find out: the form, sign, size and place of every effect
that could be there, and the exact law of the noise (its memory, its growth with the load, what does
not repeat between blocks). Like footcal it does not know the calibration, and in a drifting walk
follows it. With *d₀* the distance of the effect's signature from zero and *d₁* from the best fit of
the nearest other name, in standard deviations after calibration is fitted, a right answer comes in
at most Φ(*d₀* − 2.33) and an exact name in at most Φ(*d₁* − 2.33) of the trials (one-sided; mean
over the trials of a line). In pairs both effects are fitted, and the weaker one counts.
"""
ABOVE = """A measured figure may lie above the oracle's where a diagnosis prefers one name of
several that fit alike, since what is hidden here is then often that one.
"""
HOW = """Generators write the logs of a drawn robot, gait or set of poses, noise, converter and
block repeatability; more than half of the effects are implemented otherwise than in footcal
(`tests/blind/foreign.py`), and a third of walks and poses come from a physics engine. Truths are
committed to by SHA-256(secret + truth) and lie in a folder that the processes that diagnose
never see. Every plan line takes turns through its effects; a run that is interrupted has the same
mixture with fewer trials.

The size of a hysteresis, whatever its implementation, is the widest loop (falling less rising, N)
that the recorded loads open; both sides compute it by code of their own.

Gains are those of the quantity that footcal states (of placements the total force or one moment
about the hole, whichever gained most), by the bench's own projection.

Not measured: coverage of held-out gains in walks and stands, whose streams are filtered before a
gain is stated, so that their noise is not the generator's, and of robots that hang or stand on six
legs; walks of many minutes; a real
robot, whose truth nobody knows (`tests/real` holds what footcal says of published logs).
"""


def write_page(scores: Sequence[Score], run: Mapping[str, Any], page: Path) -> None:
    """Write the page, and its figures beside it."""
    figures = page.parent / "figures"
    figures.mkdir(parents=True, exist_ok=True)
    draw_confusion(scores, figures / "blind_confusion.png")
    draw_power(scores, figures / "blind_power.png")
    draw_risk(scores, figures / "blind_risk.png")
    limited = draw_limits(scores, figures / "blind_limits.png")
    misses = page.with_name(f"{page.stem}_misses{page.suffix}")
    misses.write_text(misses_page(scores), encoding="utf-8")
    parts = [
        INTRO + _code(scores, run) + _demands(scores) + "\n" + READING,
        "## What this means for an experimenter\n",
        *meaning(scores),
        *(_limits(scores) if limited else ()),
        "## Power\n",
        "![Power curves](figures/blind_power.png)\n",
        *_power(scores),
        "## Risk against coverage\n",
        "Names count from a least confidence (p of the cause) on; it falls from left to right.\n",
        "![Risk against coverage](figures/blind_risk.png)\n",
        "## What was hidden, what was said\n",
        "![Confusion matrix](figures/blind_confusion.png)\n",
        _wrong_names(scores),
        "## Not reached, and on which trials\n",
        f"Every miss with what footcal gave as its reason: [list]({misses.name}).\n",
        *(f"- {why}" for why in run.get("why", ())),  # read by a person from the list
        "",
        _missed(scores),
        "## The run\n",
        HOW,
        _provenance(scores, run),
        "## What is hidden\n",
        *_catalogue(),
    ]
    page.write_text("\n".join(parts).rstrip() + "\n", encoding="utf-8")


def _code(scores: Sequence[Score], run: Mapping[str, Any]) -> str:
    """Which code gave these figures, and when its logs were sealed."""
    code = f"commit `{run['commit']}`" if run.get("commit") else "the code"
    return f"{len(scores)} logs, diagnosed by {code} as it was on {run['sealed_at'][:10]}.\n\n"


def _provenance(scores: Sequence[Score], run: Mapping[str, Any]) -> str:
    seconds = [float(s.truth["seconds"]) for s in scores if s.truth.get("seconds")]
    lines = [
        f"- Seeds: **{run['stream']}**, sealed {run['sealed_at']}, opened "
        f"{datetime.now(UTC).isoformat(timespec='seconds')}.",
        "- Rules, procedure and table of effects when sealed: SHA-256 "
        f"`{run['rules_sha256'][:16]}…`; "
        f"{run['rules_changed']} of {len(scores)} verdicts were made after a change of them.",
        f"- {len(scores)} of {run['hidden']} hidden trials have a verdict; "
        f"{len(run['unreachable'])} planned trials were not made because the effect hides in the "
        "calibration at any size.",
    ]
    lines.append(_enough(scores))
    lines += [f"- {note}" for note in run.get("notes", ())]  # how a run departed from the plan
    if seconds:
        lines.append(
            f"- Calibration and diagnosis took {np.median(seconds):.1f} s of one core per trial "
            f"(median), {max(seconds):.0f} s at most."
        )
    return "\n".join(lines) + "\n"


def _enough(scores: Sequence[Score]) -> str:
    """Whether there are as many trials as the demands ask for."""
    nulls = sum(s.truth["kind"] == "null" for s in scores)
    cells = Counter((s.group, s.truth["rho"]) for s in scores if s.truth["kind"] == "single")
    fewest, most = min(cells.values(), default=0), max(cells.values(), default=0)
    singles = f"{most}" if fewest == most else f"{fewest} to {most}"
    ending = (
        "" if nulls >= 200 and fewest >= 30 else ": **too few to judge by, read the intervals**"
    )
    return (
        f"- {nulls} nulls (200 asked); {singles} single effects "
        f"per size and experiment (30 asked){ending}."
    )


def _table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    return "\n".join([*lines, *("| " + " | ".join(row) + " |" for row in rows)]) + "\n"


def _brief(share: Share) -> str:
    return f"{100 * share.value:.0f} ({share.trials})" if share.trials else "–"


def _demands(scores: Sequence[Score]) -> str:
    groups = [g for g in GROUPS if any(s.group == g for s in scores)]
    rows = []
    for demand in DEMANDS:
        share = demand.share(scores)
        measured = str(share) if share.trials else "not run"
        if share.trials and demand.sense == "at_most":
            measured += f", upper {100 * share.upper():.1f} %"
        if share.trials and not demand.met(scores):
            measured = f"**{measured}**"
        parts = (_brief(demand.share([s for s in scores if s.group == g])) for g in groups)
        most = demand.reachable(scores)
        oracle = "" if np.isnan(most) else f"{100 * most:.0f} %"
        rows.append([demand.trial, demand.score, demand.asked(), oracle, measured, *parts])
    return _table(["trial", "score", "demanded", "an oracle reaches", "measured", *groups], rows)


def _limits(scores: Sequence[Score]) -> list[str]:
    """What an oracle reaches, and which demands ask for more."""
    beyond = [
        f"*{d.trial}, {d.score}* (demanded {d.asked()}, oracle {100 * most:.0f} %)"
        for d in DEMANDS
        if (most := d.reachable(scores)) < d.bound
    ]
    words = "; ".join(beyond) + "." if beyond else "none."
    return [
        LIMITS,
        "![Oracle and measured](figures/blind_limits.png)\n",
        f"Demands beyond the oracle: {words}\n",
        ABOVE,
        _nearest(scores),
    ]


def _nearest(scores: Sequence[Score]) -> str:
    """Which other name stands in the way, by effect."""
    singles = [s for s in scores if s.truth["kind"] == "single" and s.truth.get("limit")]
    rows = []
    for key in dict.fromkeys((s.group, str(s.truth["effects"][0]["key"])) for s in singles):
        mine = [s for s in singles if (s.group, s.truth["effects"][0]["key"]) == key]
        limits = [s.truth["limit"] for s in mine]
        distance = np.median(
            [m["d1"][0] / s.truth["rho"] for m, s in zip(limits, mine, strict=True)]
        )
        whole = np.median([m["d0"][0] / s.truth["rho"] for m, s in zip(limits, mine, strict=True)])
        who = Counter(m["nearest"][0] for m in limits).most_common(1)[0][0]
        exact = np.mean([m["exact"] for m in limits])
        said = _brief(Share.of(s.exact for s in mine))
        rows.append([*key, f"{whole:.0f}", f"{distance:.1f}", who, f"{100 * exact:.0f}", said])
    head = [
        "experiment", "hidden", "d₀ at ρ 1", "d₁ at ρ 1", "nearest other name",
        "exact: oracle, %", "measured, % (trials)",
    ]  # fmt: skip
    return "By effect (medians; every ρ together):\n\n" + _table(head, sorted(rows))


def _missed(scores: Sequence[Score]) -> str:
    lines = [
        f"- *{d.trial}, {d.score}*: {d.against(scores)}."
        for d in DEMANDS
        if d.share(scores).trials and not d.met(scores)
    ]
    return "\n".join(lines or ["Every demand that was run is met."]) + "\n"


def _wrong_names(scores: Sequence[Score]) -> str:
    wrong = [s for s in scores if s.wrong]
    if not wrong:
        return f"No wrong name in {len(scores)} trials.\n"
    rows = [
        [
            s.group,
            str(s.truth["kind"]),
            " and ".join(str(e["key"]) for e in s.truth["effects"]) or "nothing",
            f"{s.truth['rho']:g}",
            ", ".join(sorted(s.verdict.names)),
            s.verdict.verdict,
        ]
        for s in wrong
    ]
    return "Every wrong name:\n\n" + _table(
        ["experiment", "trial", "hidden", "ρ", "named", "verdict"], rows
    )


def _power(scores: Sequence[Score]) -> list[str]:
    singles = [s for s in scores if s.truth["kind"] in ("single", "alias")]
    rows = []
    for key in dict.fromkeys((s.group, str(s.truth["effects"][0]["key"])) for s in singles):
        mine = [s for s in singles if (s.group, s.truth["effects"][0]["key"]) == key]
        rho, how = rho_at_power(mine)
        words = {"below": f"< {rho:g}", "above": f"> {rho:g}"}.get(how, f"{rho:.2f}")
        # sizes grow almost in proportion to ρ: the median size per ρ times the ρ found
        per_rho = np.median([abs(s.truth["effects"][0]["size"]) / s.truth["rho"] for s in mine])
        unit = str(mine[0].truth["effects"][0]["unit"])
        size = (
            f"{'' if how == 'interpolated' else words[0] + ' '}{per_rho * rho:.2g} {unit}".strip()
        )
        covered = Share.of(bool(s.covered) for s in mine if s.covered is not None)
        sets = [len(g) for s in mine for g in s.verdict.rivals if s.right]
        rivals = f"{np.median(sets):.0f} in {len(sets)}" if sets else "–"
        rows.append([*key, words, size if unit else "–", _brief(covered), rivals, str(len(mine))])
    rows.sort()
    head = [
        "experiment", "hidden", "ρ at power 0.8", "that is", "interval covers, %",
        "names in right rival sets (median)", "trials",
    ]  # fmt: skip
    return [
        "Size at which the right answer comes in four of five trials (pooled monotone curve "
        "through the ρ tried), in ρ and in the effect's own unit (median over the robots drawn).\n",
        _table(head, rows),
    ]


def _catalogue() -> list[str]:
    rows = [
        [
            key,
            ", ".join(item.right) or "none: must not be named",
            ", ".join(item.experiments),
            "foreign" if item.foreign else "footcal's table",
            ", ".join(n for n in item.alias if n not in item.right) or "–",
        ]
        for key, item in CATALOGUE.items()
    ]
    head = ["hidden", "right names", "experiments", "implementation", "alias in that experiment"]
    return [_table(head, rows)]
