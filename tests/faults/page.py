"""``docs/reliability.md``: what was tried, what a user reads, and every broken promise."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Sequence
from pathlib import Path

from tests.faults.running import Outcome


def write_page(outcomes: Sequence[Outcome], page: Path) -> None:
    """Write the page."""
    broken = [o for o in outcomes if o.violations]
    lines = [
        "# Reliability",
        "Valid inputs, each spoilt in one way drawn by seed; written by `make faults`.",
        "",
        f"{len(outcomes)} tried, {len(broken)} broke a promise.",
        "",
        "| class | inputs | exit 0 | 1 | 2 | 3 | other | broken | what a user reads |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    families: dict[str, list[Outcome]] = defaultdict(list)
    for outcome in outcomes:
        families[f"{outcome.part}: {outcome.family}"].append(outcome)
    for family, found in sorted(families.items()):
        codes = Counter(o.exit_code for o in found)
        other = sum(n for code, n in codes.items() if code not in (0, 1, 2, 3))
        said = next((o.sentence for o in found if o.exit_code in (2, 3) and not o.violations), "")
        lines.append(
            f"| {family} | {len(found)} | {codes[0]} | {codes[1]} | {codes[2]} | {codes[3]} | "
            f"{other} | {sum(bool(o.violations) for o in found)} | {_cell(said)} |"
        )
    lines += ["", "## Broken promises", ""]
    if broken:
        lines += ["| promise | times | first case |", "|---|---|---|"]
    grouped: dict[str, list[Outcome]] = defaultdict(list)
    for outcome in broken:
        grouped[_kind(outcome)].append(outcome)
    for kind, found in sorted(grouped.items(), key=lambda item: -len(item[1])):
        lines.append(
            f"| {_cell(kind)} | {len(found)} | {_cell(found[0].key)}: "
            f"{_cell(found[0].violations[0])} |"
        )
    if not broken:
        lines.append("None.")
    page.parent.mkdir(parents=True, exist_ok=True)
    page.write_text("\n".join(lines) + "\n", encoding="utf-8")


def _kind(outcome: Outcome) -> str:
    """What joins broken promises into one class."""
    first = outcome.violations[0].split(":")[0].split(",")[0]
    return f"{first} – {outcome.part}, {outcome.family}"


def _cell(text: str) -> str:
    return text.replace("|", "\\|").replace("<", "&lt;")
