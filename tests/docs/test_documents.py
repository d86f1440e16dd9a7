"""Every command, recipe, table and Python example of README and documents is run as printed."""

from __future__ import annotations

import json
import re
import shlex
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import typer

from footcal_cli.app import COMMANDS, function_of, main
from footcal_cli.commands import option_tables
from footcal_cli.core.effects.calibration import AXES
from footcal_cli.recipe import read_recipe
from tests.conftest import REPOSITORY

PAGES = [
    REPOSITORY / "README.md",
    *sorted((REPOSITORY / "docs" / "tutorials").glob("*.md")),
    *sorted((REPOSITORY / "docs" / "howto").glob("*.md")),
    REPOSITORY / "docs" / "ci.md",
    REPOSITORY / "docs" / "explanation" / "python.md",
]
USAGE_ERROR: type[Exception] = typer.BadParameter.__mro__[1]
"""What Typer raises on a command line that it cannot parse."""
WITHOUT_PICTURES = ("schema", "effects", "init", "convert", "export")
NOT_RUN = ("pip ", "pipx ")
"""Commands that would change the environment."""


@dataclass(frozen=True)
class Block:
    """A fenced block: language, the words behind it, text."""

    language: str
    info: str
    text: str

    @property
    def title(self) -> str:
        """The file that the block is, empty where it is none."""
        found = re.search(r'title="([^"]+)"', self.info)
        return found.group(1) if found else ""

    @property
    def exit_code(self) -> int:
        """How its commands end."""
        found = re.search(r"exit=(\d+)", self.info)
        return int(found.group(1)) if found else 0


def blocks(page: Path) -> list[Block]:
    text = page.read_text(encoding="utf-8")
    fences = re.findall(r"^```(\w*) ?([^\n]*)\n(.*?)^```", text, re.DOTALL | re.MULTILINE)
    return [Block(*fence) for fence in fences]


def commands(block: Block) -> list[str]:
    lines = block.text.replace("\\\n", " ").splitlines()
    stripped = (line.split("  #")[0].strip() for line in lines)
    return [line for line in stripped if line and not line.startswith("#")]


def has_slow(page: Path) -> bool:
    return any(b.language == "sh" and "slow" in b.info for b in blocks(page))


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder as a checkout looks to a reader: samples and recipes at hand."""
    for name in ("recipes", "sample_data"):
        (tmp_path / name).symlink_to(REPOSITORY / name)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def shell(line: str) -> int:
    words = shlex.split(line)
    if words[0] == "python":
        return subprocess.run([sys.executable, *words[1:]], check=False).returncode
    assert words[0] == "footcal", f"neither run nor listed in NOT_RUN: {line}"
    words += [] if words[1] in WITHOUT_PICTURES else ["--no-pictures", "--overwrite"]
    with pytest.raises(SystemExit) as end:
        main(words[1:])
    return int(end.value.code or 0)


def follow(page: Path, place: Path, *, slow: bool) -> None:
    """Write the page's files and run its commands in order."""
    for block in blocks(page):
        if block.title:
            (place / block.title).write_text(block.text, encoding="utf-8")
        if block.language != "sh" or ("slow" in block.info and not slow):
            continue
        for line in commands(block):
            if line.startswith(NOT_RUN):
                continue
            assert shell(line) == block.exit_code, line


@pytest.mark.parametrize("page", PAGES, ids=lambda p: p.stem)
def test_quick_commands_of_the_page_run(page: Path, place: Path) -> None:
    follow(page, place, slow=False)


@pytest.mark.slow
@pytest.mark.parametrize("page", [p for p in PAGES if has_slow(p)], ids=lambda p: p.stem)
def test_all_commands_of_the_page_run(page: Path, place: Path) -> None:
    follow(page, place, slow=True)


@pytest.mark.parametrize("page", PAGES, ids=lambda p: p.stem)
def test_recipes_of_the_page_can_be_read(page: Path, tmp_path: Path) -> None:
    for k, block in enumerate(blocks(page)):
        if block.language == "toml":
            recipe = tmp_path / f"{k}.toml"
            recipe.write_text(block.text, encoding="utf-8")
            read_recipe(recipe, option_tables())


def test_python_examples_run(place: Path) -> None:
    """Every calibration of the page is five lines and finds what is true of its sample."""
    page = REPOSITORY / "docs" / "explanation" / "python.md"
    names: dict[str, Any] = {}
    for example in blocks(page):
        if example.language == "python":
            exec(compile(example.text, str(page), "exec"), names)
            arrays = "import" in example.text or "def " in example.text
            assert arrays or "calibrate." not in example.text or example.text.count("\n") <= 5
    bench, biped, hexapod = (
        json.loads((place / "sample_data" / file).read_text(encoding="utf-8"))
        for file in ("bench_foot/truth.json", "biped/walk_004_truth.json", "hexapod/truth.json")
    )
    stood = json.loads((place / "sample_data/biped/stand_truth.json").read_text(encoding="utf-8"))
    legs = {
        f"{leg}.{name}": value
        for leg, truth in hexapod["legs"].items()
        for name, value in {
            "weight": truth["mass_kg"] * hexapod["gravity_mps2"],
            **dict(zip((f"offset_{axis}" for axis in AXES), truth["offset"], strict=True)),
        }.items()
    }
    for found, truth in (
        (names["found"], bench["parameters"]), (names["foot"], bench["parameters"]),
        (names["stood"], stood["parameters"]), (names["walked"], biped["parameters"]),
        *((leg, legs) for leg in names["legs"]), (names["robot"], legs),
    ):  # fmt: skip
        known = [i for i, name in enumerate(found.estimates.names) if name in truth]
        error = found.estimates.values - [truth.get(n, 0.0) for n in found.estimates.names]
        in_sd = (error / np.maximum(found.sd, 1e-300))[known]
        assert len(known) >= 2
        assert np.sqrt(np.mean(in_sd**2)) < 2.0, found.summary()
        assert len(found.summary().splitlines()) == len(found.estimates.names)


def printed_commands(page: Path) -> list[str]:
    """Every `footcal` line of a page: of its blocks, and of its text between back quotes."""
    lines = [line for b in blocks(page) if b.language in ("", "sh") for line in commands(b)]
    prose = re.sub(r"^```.*?^```", "", page.read_text("utf-8"), flags=re.DOTALL | re.MULTILINE)
    lines += re.findall(r"(?<!`)`(footcal [^`\n]+)`(?!`)", prose)
    return [line for line in lines if line.startswith("footcal ") and line.split()[2:]]


def test_every_printed_command_line_can_be_parsed() -> None:
    """Options and commands exist, and so do the recipes that are named; nothing is run."""
    pages = [REPOSITORY / "README.md", *sorted((REPOSITORY / "docs").rglob("*.md"))]
    lines = [(page.name, line) for page in pages for line in printed_commands(page)]
    assert len(lines) > 60
    wrong = [f"{page}: {line}: {why}" for page, line in lines if (why := _fault(line))]
    assert not wrong, "\n".join(wrong)


def _fault(line: str) -> str:
    """Why a command line cannot be followed, empty where it can."""
    name, *words = shlex.split(line.replace("…", "LOG"))[1:]
    words = [word for word in words if word not in ("--json", "--debug")]
    if name not in COMMANDS:
        return "" if name in ("--help", "--version") else "no such command"
    one = typer.Typer(add_completion=False)
    one.command(name)(function_of(name))
    try:
        context = typer.main.get_command(one).make_context(name, words)
    except typer.Exit:  # --help
        return ""
    except USAGE_ERROR as error:
        return str(error)
    recipe = Path(context.params.get("recipe") or "")
    shipped = recipe.parts[:1] == ("recipes",)
    return "" if not shipped or (REPOSITORY / recipe).is_file() else f"no {recipe}"


@pytest.mark.parametrize(
    ("line", "fault"),
    [
        ("footcal offline-fit w.csv --out o", ""),
        ("footcal offline-fitt w.csv", "no such command"),
        ("footcal offline-fit w.csv --oot o", "--oot"),
        ("footcal check l.csv --recipe recipes/nobody.toml", "nobody.toml"),
    ],
)
def test_a_command_line_that_cannot_be_followed_is_seen(line: str, fault: str) -> None:
    assert fault in _fault(line)
    assert bool(_fault(line)) is bool(fault)


LINK = re.compile(r"\]\((?!https?://|#)([^)#\s]+)")
SITE_ONLY = "reference/"
"""Pages that `make docs` generates."""


@pytest.mark.parametrize(
    "page", [REPOSITORY / "README.md", *sorted((REPOSITORY / "docs").rglob("*.md"))],
    ids=lambda p: p.relative_to(REPOSITORY).as_posix(),
)  # fmt: skip
def test_links_lead_to_files(page: Path) -> None:
    for target in LINK.findall(page.read_text(encoding="utf-8")):
        if not target.startswith(SITE_ONLY):
            assert (page.parent / target).exists(), target
