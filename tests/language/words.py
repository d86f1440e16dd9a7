"""Which words must not reach users, and where users read.

Users read every text of the product that is not a docstring of its inside: string constants of the
rooms that face them, help of commands, README and documents.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = ROOT / "footcal_cli"
FORBIDDEN = {
    r"\bseed[ -]?[12]\b": "name the paper by author and title, see CITATION.cff",
    r"\bnats?\b": "information gain (bits), or what it means for the user",
    r"\bours\b": "name the tool or the method",
    r"\btold\b": "reported, distinguished or found",
    r"\btells? (?:\w+ ){0,3}apart\b|\btell (?:\w+ ){0,3}from\b": "distinguish",
    r"\b(?:is|are) left\b(?! out)|\bwhat is left\b|\bleft beside\b": "residual, remaining",
    r"\bleft (?:in […{]|in (?:these|the) data|over)\b": "residual",
    r"\bbeside\b": "next to, besides, together with",
    r"\bkindred\b|\bcontest\b": "rivals, comparison",
    r"\btells? (?:the|which|an?)\b|\btells? it from\b|\bto tell\b": "determine, show, distinguish",
    r"\bsurpris\w+": "innovation, residual",
    r"\bforce left\b|\bleft \((?:N|mm|Nm)\)": "residual",
    r"\bwhere it pays\b|\bpays on\b": "helps, is supported by held-out data",
    r"\bturned signs?\b|\bsigns? (?:\w+ )?turned\b": "reversed sign",
    r"\bno sample\w* (?:of \w+ \w+ )?counts?\b": "can be used",
    r"\bfor who\b": "for readers who",
    r"\bforetell\w*\b": "predict",
    r"\bclimb(?:s|ed)?\b": "extend, select",
    r"\bnot yet seen\b|\bblocks know\b": "held out, informative blocks",
    r"\bwherever they count\b|\bwhat was named\b": "identified",
}
"""Pattern -> what to write instead."""
PAPERS = ("NAO CoP self-calibration", "Wu & Revzen")
"""Short names of the papers that CITATION.cff lists."""
PLURALS = (
    r"\b1 (?:findings|rows|cells|channels|samples|blocks|sessions|loads|runs|legs|poses|stances"
    r"|cycles|columns|logs|placements)\b"
    r"|\ball 1\b|\ba (?:findings|channels|cells|rows)\b|\w\(s\)"
)
_RECORDS = ("blind_bench_misses.md",)
"""Pages that quote what a sealed run printed."""
_ROOMS = (
    "commands", "sheets", "plots", "report", "exporters", "formats", "intake", "recipe", "session",
    "tables", "sniff", "batch",
)  # fmt: skip
_FILES = ("app.py", "errors.py")
_CORE = ("core",)


@dataclass(frozen=True)
class Found:
    """A text that should be written otherwise."""

    where: str
    text: str
    remedy: str

    def __str__(self) -> str:
        return f"{self.where}: {self.text!r} -> {self.remedy}"


def faults(text: str, where: str) -> Iterator[Found]:
    """Every forbidden word and wrong plural of a text, with its surroundings."""
    rules = {**FORBIDDEN, PLURALS: "a number and its noun agree: footcal_cli.report.plural"}
    if not any(paper in text for paper in PAPERS):
        rules[r"\beqs?\. ?\(?\d+"] = "an equation's number needs the paper: see CITATION.cff"
    for pattern, remedy in rules.items():
        for hit in re.finditer(pattern, text, re.IGNORECASE):
            around = text[max(hit.start() - 30, 0) : hit.end() + 30].replace("\n", " ")
            yield Found(where, around, remedy)


def sources() -> list[Path]:
    """Python files whose strings users read."""
    rooms = [path for room in _ROOMS for path in (PACKAGE / room).rglob("*.py")]
    core = [p for name in _CORE for p in ([PACKAGE / name] if name.endswith(".py") else
            sorted((PACKAGE / name).rglob("*.py")))]  # fmt: skip
    return sorted({*rooms, *core, *(PACKAGE / name for name in _FILES)})


def strings(path: Path) -> Iterator[tuple[int, str]]:
    """String constants that are no docstrings; of a command's module its help as well."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    silent: set[int] = set()
    for node in ast.walk(tree):
        if not isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef):
            continue
        for inner in node.body:
            if isinstance(inner, ast.Expr) and isinstance(inner.value, ast.Constant):
                is_help = (
                    isinstance(node, ast.FunctionDef)
                    and path.parent.name == "commands"
                    and not node.name.startswith("_")
                )
                if not is_help:
                    silent.add(id(inner.value))
    for node in ast.walk(tree):
        if isinstance(node, ast.JoinedStr):
            parts = [v.value if isinstance(v, ast.Constant) else "…" for v in node.values]
            silent.update(id(v) for v in node.values)
            yield node.lineno, "".join(str(part) for part in parts)
    for node in ast.walk(tree):
        if (
            isinstance(node, ast.Constant)
            and isinstance(node.value, str)
            and id(node) not in silent
        ):
            yield node.lineno, node.value


def documents() -> list[Path]:
    """README, changelog and pages."""
    pages = {ROOT / "README.md", ROOT / "CHANGELOG.md", *(ROOT / "docs").rglob("*.md")}
    return sorted(path for path in pages if path.name not in _RECORDS)


def unknown_words(text: str, where: str, glossary: str) -> Iterator[Found]:
    """Working words, which pages set in italics, that the glossary does not hold."""
    for word in re.findall(r"(?<!\*)\*([a-z][a-z -]{2,24})\*(?!\*)", text):
        if not re.search(rf"\b{re.escape(word)}\b", glossary, re.IGNORECASE):
            yield Found(where, word, "explain it in GLOSSARY.md, or use a word that stands there")


def guides() -> list[Path]:
    """Pages by which users learn: README, tutorials, how-tos, explanations."""
    folders = ("tutorials", "howto", "explanation")
    pages = (page for name in folders for page in (ROOT / "docs" / name).glob("*.md"))
    return [ROOT / "README.md", *sorted(pages)]


def all_faults() -> list[Found]:
    """Everything in the product that users should not read."""
    found = [
        fault
        for path in sources()
        for line, text in strings(path)
        if " " in text
        for fault in faults(text, f"{path.relative_to(ROOT)}:{line}")
    ]
    for path in documents():
        lines = path.read_text(encoding="utf-8").splitlines()
        text = "\n".join(line for line in lines if not line.startswith(">"))  # quoted output
        found += faults(text, path.relative_to(ROOT).as_posix())
    glossary = (ROOT / "GLOSSARY.md").read_text(encoding="utf-8")
    for path in guides():
        text = re.sub(r"^```.*?^```", "", path.read_text("utf-8"), flags=re.DOTALL | re.MULTILINE)
        found += unknown_words(text, path.relative_to(ROOT).as_posix(), glossary)
    return found


if __name__ == "__main__":
    every = all_faults()
    for one in every:
        print(one)  # noqa: T201 - the answer of a check
    raise SystemExit(bool(every))
