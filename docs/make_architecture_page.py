"""Make docs/architecture.md: imports, circles and lines read from the source, paths from runs.

``python docs/make_architecture_page.py``; subsystems are the packages of the core and the rooms
around it, as `tests.test_layers` names them.
"""

from __future__ import annotations

import ast
import sys
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cache
from inspect import CO_OPTIMIZED
from pathlib import Path
from tempfile import TemporaryDirectory
from types import FrameType
from typing import Any

HERE = Path(__file__).resolve().parent
REPOSITORY = HERE.parent
PACKAGE = REPOSITORY / "footcal_cli"
LEVELS = (
    ("start", ("__main__", "app")),
    ("commands", ("commands", "batch", "formats", "exporters", "sniff")),
    ("around", ("session", "intake", "sheets", "plots", "report", "recipe")),
    ("files", ("tables", "records", "errors")),
    ("core", ("core",)),
)  # fmt: skip
"""Rooms from the door to the ground; what is in none of them stands with "around"."""
PATHS = {
    "A weights log": ("offline-fit", "--recipe", "recipes/nao_table2.toml"),
    "A walk": (
        "online-replay", "sample_data/biped/walk_002_cells.parquet",
        "sample_data/biped/walk_002_body.parquet", "--recipe", "recipes/nao_walk.toml",
    ),
    "A diagnosis": (
        "diagnose", "sample_data/bench_foot/weights.csv", "--experiment", "weights", "--recipe",
        "recipes/bench_foot.toml",
    ),
}  # fmt: skip


BEFORE = {
    "core.diagnosis": 11456, "commands": 5921, "core.bench": 4153, "core.online": 3938,
    "sheets": 3876, "core.effects": 2741, "core.pose": 2380, "core.simulation": 2371,
    "plots": 1905, "core.hang": 1646, "core.experiments": 495, "records": 479,
    "core.quality": 389, "tables": 348, "core.evidence": 346, "core.static_init": 344,
    "intake": 343, "session": 324, "core.signals": 324, "columns": 302, "recipe": 240,
    "core.contact": 234, "core.observability": 207, "core.wiring": 195, "core.fit": 195,
    "core.centroidal": 185, "core.spatial": 184, "core.chain": 180, "report": 168,
    "core.quiet": 163, "core.parameters": 161, "core.next_stance": 103, "app": 93, "errors": 86,
    "core.stance_curve": 73, "core.log": 69, "__init__": 29, "__main__": 5, "core": 4,
}  # fmt: skip
"""Lines of each subsystem at commit 6403e2b, from where the house was built anew."""


def module_name(path: Path) -> str:
    """``core.online.memory`` of its file."""
    parts = path.relative_to(PACKAGE).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" and len(parts) > 1 else parts)


def subsystem(module: str) -> str:
    """The room of a module; in the core its package, or the file where it lies bare."""
    return ".".join(module.split(".")[: 2 if module.startswith("core.") else 1])


@cache
def nodes_of(path: Path) -> tuple[ast.AST, ...]:
    """All nodes of a source, which is read and parsed once."""
    return tuple(ast.walk(ast.parse(path.read_text(encoding="utf-8"))))


def imports_of(path: Path, known: Mapping[str, Path]) -> Iterator[str]:
    """Modules of footcal that a file imports when it runs, wherever in it; types alone are none."""
    nodes = nodes_of(path)
    for_types = {
        id(inner)
        for node in nodes
        if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test)
        for inner in ast.walk(node)
    }
    for node in nodes:
        if not isinstance(node, ast.ImportFrom) or id(node) in for_types:
            continue
        name = (node.module or "").removeprefix("footcal_cli").lstrip(".")
        if not (node.module or "").startswith("footcal_cli"):
            continue
        for alias in node.names:
            whole = f"{name}.{alias.name}".lstrip(".")
            if whole in known:
                yield whole
            elif name in known:
                yield name


def modules() -> dict[str, Path]:
    """All modules of the package by name."""
    return {module_name(path): path for path in sorted(PACKAGE.rglob("*.py"))}


def arrows() -> Counter[tuple[str, str]]:
    """Imports between subsystems: (from, to) -> how many."""
    known = modules()
    return Counter(
        (subsystem(name), subsystem(other))
        for name, path in known.items()
        for other in set(imports_of(path, known))
        if subsystem(name) != subsystem(other)
    )


def circles(edges: Counter[tuple[str, str]]) -> list[tuple[str, ...]]:
    """Groups of subsystems that import each other, directly or around (Tarjan)."""
    after: dict[str, list[str]] = {}
    for start, end in edges:
        after.setdefault(start, []).append(end)
        after.setdefault(end, [])
    index: dict[str, int] = {}
    low: dict[str, int] = {}
    stack: list[str] = []
    found: list[tuple[str, ...]] = []

    def visit(node: str) -> None:
        index[node] = low[node] = len(index)
        stack.append(node)
        for other in after[node]:
            if other not in index:
                visit(other)
                low[node] = min(low[node], low[other])
            elif other in stack:
                low[node] = min(low[node], index[other])
        if low[node] == index[node]:
            group = stack[stack.index(node) :]
            del stack[stack.index(node) :]
            if len(group) > 1:
                found.append(tuple(sorted(group)))

    for node in sorted(after):
        if node not in index:
            visit(node)
    return sorted(found)


@dataclass
class Walked:
    """What a run went through: files in the order of their first call, and types it made."""

    files: dict[str, None] = field(default_factory=dict)
    types: set[str] = field(default_factory=set)

    def __call__(self, frame: FrameType, event: str, _argument: Any) -> None:
        """Note a call, as `sys.setprofile` tells of it."""
        if event != "call":
            return
        file = frame.f_code.co_filename
        # bodies of modules and classes run, and call, when they are imported, by whomever
        if file.startswith(str(PACKAGE)) and frame.f_code.co_flags & CO_OPTIMIZED:
            name = module_name(Path(file))
            if name not in self.files and not imported(frame):
                self.files[name] = None
        if frame.f_code.co_name == "__init__":
            made = type(frame.f_locals.get("self"))
            if made.__module__.startswith("footcal_cli"):
                self.types.add(f"{made.__module__}.{made.__name__}")


def imported(frame: FrameType | None) -> bool:
    """Whether a module of footcal is being imported, and this call serves that."""
    while frame is not None:
        if frame.f_code.co_name == "<module>" and frame.f_code.co_filename.startswith(str(PACKAGE)):
            return True
        frame = frame.f_back
    return False


def walked(words: tuple[str, ...]) -> Walked:
    """Run a command and note its way."""
    from footcal_cli.app import main

    seen = Walked()
    named = [str(REPOSITORY / word) if (REPOSITORY / word).is_file() else word for word in words]
    with TemporaryDirectory() as folder:
        sys.setprofile(seen)
        try:
            main([*named, "--out", f"{folder}/run", "--quiet", "--no-pictures"])
        except SystemExit:
            pass
        finally:
            sys.setprofile(None)
    return seen


def ground(edges: Counter[tuple[str, str]]) -> set[str]:
    """Bare files of the core that import no package of it, directly or around."""
    inner = {name for pair in edges for name in pair if name.startswith("core.")}
    low = {name for name in inner if not (PACKAGE / "core" / name[5:]).is_dir()}
    while True:
        high = {start for start, end in edges if start in low and end in inner and end not in low}
        if not high:
            return low
        low -= high


def drawing(edges: Counter[tuple[str, str]], inside: bool) -> str:
    """The imports as a Mermaid graph: of the rooms, or of the packages of the core."""
    drawn: Counter[tuple[str, str]] = Counter()
    low = ground(edges)
    for (start, end), count in edges.items():
        if inside:
            if start.startswith("core.") and end.startswith("core.") and not {start, end} & low:
                drawn[start.removeprefix("core."), end.removeprefix("core.")] += count
        else:
            pair = start.split(".")[0], end.split(".")[0]
            drawn[pair] += count if pair[0] != pair[1] else 0
    ringed = {name for group in circles(drawn) for name in group}
    lines = ["```mermaid", "flowchart TD"]
    nodes = {name for pair, count in drawn.items() if count for name in pair}
    if not inside:
        placed = {room: level for level, rooms in LEVELS for room in rooms}
        for level in dict(LEVELS):
            rooms = [n for n in sorted(nodes) if placed.get(n, "around") == level]
            members = "; ".join(rooms)
            lines.append(f"  subgraph {level}_rooms[{level}]\n    {members}\n  end")
    lines += [f"  {a} -->|{count}| {b}" for (a, b), count in sorted(drawn.items()) if count]
    lines += [f"  style {name} stroke:#c00,stroke-width:2px" for name in sorted(ringed)]
    return "\n".join([*lines, "```"])


def before(name: str) -> str:
    """Lines that a subsystem had."""
    return f"{BEFORE[name]:,}" if name in BEFORE else "–"


def page() -> str:
    """The page as Markdown."""
    known, edges = modules(), arrows()
    lines, files = Counter[str](), Counter[str]()
    for name, path in known.items():
        files[subsystem(name)] += 1
        lines[subsystem(name)] += len(path.read_text(encoding="utf-8").splitlines())
    fan_out = Counter(start for start, _ in edges)
    fan_in = Counter(end for _, end in edges)
    rows = [
        f"| {name} | {files[name]} | {count:,} | {before(name)} | "
        f"{fan_out[name]} | {fan_in[name]} |"
        for name, count in lines.most_common()
    ]
    gone = ", ".join(f"{name} ({count:,})" for name, count in BEFORE.items() if name not in lines)
    rings = [f"- {' · '.join(group)}" for group in circles(edges)] or ["None."]
    ways = []
    for title, words in PATHS.items():
        seen = walked(words)
        rooms = dict.fromkeys(subsystem(name) for name in seen.files)
        ways.append(
            f"- {title} (`footcal {words[0]}`): {len(seen.files)} files, {len(seen.types)} types: "
            f"{' → '.join(rooms)}."
        )
    return "\n".join(
        [
            "# How footcal is built",
            "",
            "Made by `docs/make_architecture_page.py` from the source; numbers on arrows are "
            "imports. Imports for types alone are left out. Rooms outlined in red import each "
            "other in a circle.",
            "",
            "## Rooms", "", drawing(edges, inside=False), "",
            "## Packages of the core", "",
            "All stand on these files, which import no package: "
            + ", ".join(sorted(name.removeprefix("core.") for name in ground(edges))) + ".",
            "", drawing(edges, inside=True), "",
            "## Circles", "", *rings, "",
            "## The way of a log",
            "",
            "Files in which a function ran and types of footcal that were made, rooms in the "
            "order of their first call.",
            "",
            *ways, "",
            "## Lines",
            "",
            f"{sum(files.values())} files, {sum(lines.values()):,} lines; "
            f"{sum(BEFORE.values()):,} lines at commit 6403e2b. Rooms that are gone since: {gone}. "
            "No command, option or effect of that commit is gone (`tests/contract`).",
            "",
            "| subsystem | files | lines | at 6403e2b | imports from | imported by |",
            "|---|---|---|---|---|---|",
            *rows,
            "",
        ]
    )  # fmt: skip


if __name__ == "__main__":
    (HERE / "architecture.md").write_text(page(), encoding="utf-8")
