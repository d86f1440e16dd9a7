"""Metamorphic relations: changes of an input after which the answer must be the same.

Each is stated as a change of files or of the command line, and, where names or units of the answer
change with it, as what the answer must then be.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import pandas as pd

from tests.faults.bases import BASES, Base
from tests.faults.facts import Facts, differences, facts_of
from tests.faults.judging import call, laid_out, not_drawn, spoken, words_in
from tests.faults.running import Job, Outcome

Words = list[str]
Change = Callable[[Path, Words], Words]
Expected = Callable[[Facts], Facts]

EXACT, ROUNDED, GEOMETRY = 1e-6, 1e-3, 1e-2
"""Tolerances in sd: another spelling, another unit, another frame."""


@dataclass(frozen=True)
class Relation:
    """A change that must not matter.

    Parameters
    ----------
    name, family, base
        In words; the base case.
    change
        Changes files in the folder, returns the command line.
    sds
        How far numbers may move.
    expected
        What becomes of the unchanged answer.
    words
        Whether verdict and findings stay the same.
    """

    name: str
    family: str
    base: Base
    change: Change
    sds: float = EXACT
    expected: Expected = lambda facts: facts
    words: bool = True

    @property
    def key(self) -> str:
        """The relation in one line."""
        return f"{self.base.name} | {self.name}"


def relation_jobs(relations: Iterable[Relation], inputs: Path) -> list[Job]:
    """Relations as jobs."""
    return [Job(r.key, "relation", r.family, partial(_check, r, inputs)) for r in relations]


def _check(relation: Relation, inputs: Path, folder: Path) -> Outcome:
    was = relation.expected(unchanged(relation.base, inputs, folder))
    laid_out(relation.base, inputs, folder)
    words = relation.change(folder, words_in(relation.base, folder))
    out = folder / relation.base.out
    with not_drawn():
        code, _, err = call([*words, "--out", str(out)])
    broken = spoken(code, err)
    if not out.is_dir():
        broken.append(f"exit code {code}: {err.strip()[:200]}")
    else:
        broken += differences(was, facts_of(out), sds=relation.sds, words=relation.words)
    said = err.strip().splitlines()[0] if err.strip() else ""
    return Outcome(relation.key, "relation", relation.family, code, said, "", tuple(broken[:3]))


def unchanged(base: Base, inputs: Path, folder: Path) -> Facts:
    """The answer to the base case, worked out once."""
    kept = inputs / "facts" / f"{base.name}.json"
    if not kept.is_file():
        kept.parent.mkdir(exist_ok=True)
        laid_out(base, inputs, folder)
        with not_drawn():
            call([*words_in(base, folder), "--out", str(folder / base.out)])
        facts_of(folder / base.out).save(kept)
    return Facts.load(kept)


def read_log(path: Path) -> pd.DataFrame:
    """A log of a base case."""
    return pd.read_csv(path)


def of_logs(change: Callable[[pd.DataFrame], pd.DataFrame]) -> Change:
    """Change every log of a base case in place."""

    def changed(folder: Path, words: Words) -> Words:
        for word in words:
            if word.endswith(".csv"):
                change(read_log(Path(word))).to_csv(word, index=False)
        return words

    return changed


def bases_of(*names: str) -> Iterator[Base]:
    """Base cases that this machine can run."""
    return (BASES[name] for name in names if name in BASES)
