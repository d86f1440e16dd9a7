"""``docs/reliability.md``: what was tried, what a user reads, and every broken promise."""

from __future__ import annotations

import re
from collections import Counter, defaultdict
from collections.abc import Sequence
from pathlib import Path

from tests.faults.promises import promise_lines, turned_lines
from tests.faults.running import Outcome

_PARTS = {
    "input": ("Bad inputs", "a valid input of a command, spoilt in one way"),
    "machine": (
        "A machine that fails", "from a random file access on, or from the start, the system fails"
    ),
    "kill": ("Killed runs", "a signal at a random file access or time; the next run must succeed"),
    "race": ("Races", "two runs write one folder at the same time"),
    "relation": ("Relations", "a change of the input after which the answer must be the same"),
    "seen": ("What check sees", "a log of weights, of a walk, a stand or a hanging with one fault"),
    "unseen": (
        "Faults written down beforehand",
        "39 faults of all six experiments, in a file before anybody saw what `check` says of them",
    ),
}  # fmt: skip
_LOOKED = ("seen", "unseen")
_COUNTED = {
    "tracebacks or warnings of the interpreter": ("a traceback", "a warning of the interpreter"),
    "exits 70": ("exit code 70",),
    "numbers moved in silence": ("moved", "wrong data are called good", "said "),
    "half results": ("half a result", "left behind", "the earlier result is gone", "no run.json",
                     "no report.html", "no run folder", "both wrote", "no parameters.json"),
    "inputs touched": ("input touched",),
    "runs without an end": ("runs longer", "waits for ever", "the process died"),
}  # fmt: skip


def write_page(
    outcomes: Sequence[Outcome], planned: Sequence[str], page: Path,
    before: Sequence[Outcome] = (), drawn_by: str = "",
) -> None:  # fmt: skip
    """Write the page.

    Parameters
    ----------
    outcomes
        What was tried.
    planned
        Keys of all jobs.
    before
        What broke a promise at first; `outcomes` holds what came of it on the code of today.
    drawn_by
        Arguments that draw the corpus again.
    """
    count = Counter(o.part for o in outcomes)
    broken = [o for o in outcomes if o.violations]
    lines = [
        "# Reliability",
        "",
        "Written by `make faults`: what was tried to make footcal misread a log, lose a result or "
        "touch an input, and what came of it. Every case is drawn by seed and can be repeated"
        + (f" (`python -m tests.faults {drawn_by}`)." if drawn_by else "."),
        "",
        f"{count['input']} bad inputs, {count['machine'] + count['kill'] + count['race']} injected "
        f"faults and {count['relation']} relations were tried"
        + (f" ({len(outcomes)} of the {len(planned)} of the whole corpus)"
           if len(outcomes) < len(planned) else "")
        + f"; {len(broken)} broke a promise.",
        "",
        "| what must not happen | cases |",
        "|---|---|",
    ]  # fmt: skip
    looked = [o for o in outcomes if o.part in _LOOKED]
    others = [o for o in outcomes if o.part not in _LOOKED]
    said = [[v for o in others for v in o.violations if v.startswith(s)] for s in
            _COUNTED.values()]  # fmt: skip
    lines += [f"| {name} | {len(v)} |" for name, v in zip(_COUNTED, said, strict=True)]
    rest = [v for o in others for v in o.violations]
    rest = [
        v for v in rest if not v.startswith(tuple(s for each in _COUNTED.values() for s in each))
    ]
    lines.append(f"| anything else: another exit code, several lines of error | {len(rest)} |")
    if looked:
        missed = sum(bool(o.violations) for o in looked)
        lines.append(f"| a fault of a log that `check` does not see | {missed} of {len(looked)} |")
    lines += ["", "## What it once did", "", "Seen in an early version; each is turned round, and "
              "a test of `make test` guards it.", "", *promise_lines()]  # fmt: skip
    lines += ["", "## What was said of commit 6403e2b", "", "The tests stand in one file that runs "
              "on any version from the command line alone (`tests/cli/test_turned_round.py` says "
              "how).", "", *turned_lines()]  # fmt: skip
    for part, (title, words) in _PARTS.items():
        own = [o for o in outcomes if o.part == part]
        if part in _LOOKED and own:
            lines += ["", f"## {title}", "", f"{words[0].upper()}{words[1:]}; `footcal check` must "
                      f"say something: {_seen(own)}.", "", *_seen_table(own)]  # fmt: skip
        elif own:
            lines += ["", f"## {title}", "", f"{words[0].upper()}{words[1:]}.", "", *_table(own)]
    lines += ["", "## Commands", "", "| base case | tried | of |", "|---|---|---|"]
    of, tried = (Counter(k.split(" | ")[0] for k in keys) for keys in
                 (planned, [o.key for o in outcomes]))  # fmt: skip
    lines += [f"| {base} | {tried[base]} | {n} |" for base, n in sorted(of.items())]
    lines += ["", "## Broken promises", ""]
    if broken:
        lines += ["| case | exit | what was wrong |", "|---|---|---|"]
    lines += [f"| {_cell(o.key)} | {o.exit_code} | {_cell(o.violations[0])} |" for o in broken]
    if not broken:
        lines.append("None.")
    if before:
        still = {o.key for o in broken}
        lines += ["", "## Broken at first", "", "These broke a promise when the corpus ran, "
                  "and were tried again on the code of today; all others ran once, before.", "",
                  "| case | what was wrong | today |", "|---|---|---|"]  # fmt: skip
        lines += [
            f"| {_cell(o.key)} | {_cell(o.violations[0])} | "
            f"{'broken' if o.key in still else 'kept'} |"
            for o in before
        ]
    page.parent.mkdir(parents=True, exist_ok=True)
    page.write_text("\n".join(lines) + "\n", encoding="utf-8")


def _table(outcomes: Sequence[Outcome]) -> list[str]:
    """One row per class: how it ended, and what a user reads."""
    families: dict[str, list[Outcome]] = defaultdict(list)
    for outcome in outcomes:
        families[outcome.family].append(outcome)
    lines = ["| class | cases | exit codes | broken | what a user reads |", "|---|---|---|---|---|"]
    for family, found in sorted(families.items()):
        codes = sorted(Counter(o.exit_code for o in found).items())
        ended = ", ".join(f"{n} × {_code(code)}" for code, n in codes)
        good = [
            o.sentence for o in found if o.exit_code in (2, 3, 74, 130, 143) and not o.violations
        ]
        lines.append(
            f"| {family} | {len(found)} | {ended} | {sum(bool(o.violations) for o in found)} | "
            f"{_cell(min(good, key=len) if good else '')} |"
        )
    return lines


def _seen(outcomes: Sequence[Outcome]) -> str:
    seen = sum(not o.violations for o in outcomes)
    return f"{seen} of {len(outcomes)} seen"


def _seen_table(outcomes: Sequence[Outcome]) -> list[str]:
    """A row per log and fault: how often it was seen."""
    lines = ["| log | fault | seen |", "|---|---|---|"]
    kinds: dict[tuple[str, str], list[Outcome]] = defaultdict(list)
    for outcome in outcomes:
        base, fault, _ = outcome.key.split(" | ")
        kinds[base, fault].append(outcome)
    return lines + [
        f"| {base.removeprefix('check_')} | {_cell(fault)} | {_seen(found)} |"
        for (base, fault), found in sorted(kinds.items())
    ]


def _code(code: int) -> str:
    return "killed" if code < 0 else str(code)


def _cell(text: str) -> str:
    text = re.sub(r"/\S*/(?=site-packages/|footcal_cli/)", "", text)  # no path of a machine
    return text.replace("|", "\\|").replace("<", "&lt;")
