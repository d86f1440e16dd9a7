"""Names of files with the same columns: what tells them apart, and the loads that they say.

Room: sniff; asked by file_names.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from footcal_cli.sniff.names import common_start, name_guess
from footcal_cli.sniff.plan import NOT_SAID, Entry
from footcal_cli.sniff.tokens import IN_WORDS
from footcal_cli.sniff.units import MASSES, WEIGHTS, known_unit
from footcal_cli.sniff.vocabulary import LEGS, OF_A_ROW, WITH_A_LEG

_LOAD = re.compile(
    r"(\d+(?:[.,p]\d+)?)[ _]*(kg|g|N|lb|lbs|mg|kN|oz|ozf|kgf|gf|lbf|daN|mN)?", re.IGNORECASE
)
_CELLS = {*OF_A_ROW, "loadcell", "lc"}
_PAIRS = ("id", "gd", "sd", "ed", "lr", "hm", "vh", "lp", "vp")
"""First letters of left and right: izquierda, gauche, sinistra, esquerda, hidari, vänster, lewa."""
_NOTHING = {"tare", "zero", "empty", "noload", "no_load", "unloaded", "leer", "null"}


@dataclass(frozen=True)
class Names:
    """Names of files: what all begin and end with, and what stands between."""

    head: str
    tail: str
    middle: tuple[str, ...]

    @classmethod
    def of(cls, names: Sequence[str]) -> Names:
        """What some names begin and end with, and what of each stands between."""
        head = common_start(names).rstrip("0123456789.+-")
        tail = common_start([name[::-1] for name in names])[::-1]
        word = re.sub(r"[A-Za-z]+$", "", head)
        between = [n[len(word) : len(n) - len(tail)] for n in names]
        sides = all(n.lower() in WITH_A_LEG for n in between)  # sol and sag
        if word < head and (sides or all(name_guess(n).place for n in between)):
            head = word  # fl and fr are legs, l and r sides
        longest = min(map(len, names)) - len(head)
        tail = tail[-longest:] if longest > 0 else ""
        while tail and tail[0].isalnum():
            tail = tail[1:]
        return cls(head, tail, tuple(name[len(head) : len(name) - len(tail)] for name in names))

    @property
    def whole(self) -> tuple[str, ...]:
        """The names as they are."""
        return tuple(f"{self.head}{word}{self.tail}" for word in self.middle)

    @property
    def match(self) -> str:
        """Pattern of the names."""
        return f"{escaped(self.head)}*{escaped(self.tail)}"

    @property
    def feet(self) -> list[str]:
        """Left and right of two words that differ by their first letter: ``lfcell``, ``rfcell``."""
        return by_letters([word.strip("_- .") for word in self.middle])

    @property
    def of_folders(self) -> bool:
        """Whether the folders' names tell the logs apart."""
        return "/" in self.tail

    @property
    def _word_before(self) -> str:
        """The word that stands before what tells the names apart; empty where none does."""
        before = re.search(r"([^\W\d_]+)[\W_]*$", self.head)
        return "" if before is None else before[1].lower()

    @property
    def of_cells(self) -> bool:
        """Whether a word for cells stands before the numbers that tell the names apart."""
        return self._word_before in _CELLS

    @property
    def legs(self) -> dict[str, str]:
        """Word -> leg, where a word for legs stands before a letter or two, or a number, of each.

        In whatever language, and whatever the letters stand for.
        """
        short = all(re.fullmatch(r"[A-Za-z]{1,2}|\d{1,2}", word) for word in self.middle)
        if self._word_before not in LEGS or not short:
            return {}
        return as_legs(self.middle)

    @property
    def with_unit(self) -> tuple[tuple[str, ...], str]:
        """What stands between with the letters behind it, and the expression that finds it."""
        unit = re.match(r"[A-Za-z]*", self.tail)
        end = unit[0] if unit else ""
        words = tuple(word + end for word in self.middle)
        inner = f".+/.+{end}" if all("/" in word for word in words) else f".+{end}"
        return words, f"^{re.escape(self.head)}({inner}){re.escape(self.tail[len(end) :])}$"

    @property
    def expression(self) -> str:
        """Regular expression whose group is what stands between."""
        return f"^{re.escape(self.head)}(.+){re.escape(self.tail)}$"


def as_legs(words: Sequence[str]) -> dict[str, str]:
    """Word of a file's name -> its leg in a recipe."""
    return {word: word.lower() if word[0].isalpha() else f"leg_{word}" for word in words}


def loads_named(names: Names) -> Entry | None:
    """Loads in names of files: numbers, all with one unit or each with its own."""
    found = [_LOAD.fullmatch(word.strip("_- ")) for word in names.middle]
    nothing = [word.strip("_- ").lower() in _NOTHING for word in names.middle]
    if not all(f or none for f, none in zip(found, nothing, strict=True)):
        return _among_words(names)
    if len({f[1] if f else "0" for f in found}) < 2:
        return None
    spelled = [known_unit(f[2]) if f and f[2] else None for f in found]
    units = {unit for unit in spelled if unit}
    if not units and (behind := re.match(r"[ _-]*([A-Za-z]+)(?![A-Za-z])", names.tail)):
        said = known_unit(behind[1]) or ""
        units = {said} & {*MASSES, *WEIGHTS, "lbf", "kgf", "gf"}
        spelled = [next(iter(units), None)] * len(found)
    numbers = [float(f[1].replace("p", ".").replace(",", ".")) if f else 0.0 for f in found]
    simple = all(f and re.fullmatch(r"\d+(?:\.\d+)?", f[1]) for f in found)
    # a number without a unit among others is nothing, or not understood
    if units and any(not u and n for u, n in zip(spelled, numbers, strict=True)):
        return None
    if len(units) <= 1 and simple:
        expression = rf"^{re.escape(names.head)}[_ -]*(\d+(?:\.\d+)?)"
        expression += "[^/]*/" if names.of_folders else ""
        return Entry(
            file_name=expression, unit=next(iter(units), NOT_SAID),
            sure="likely" if units else "guess", why="a number in the file's name",
        )  # fmt: skip
    unit = next(iter(units), NOT_SAID)
    if len(units) > 1:
        sizes = next((s for s in (MASSES, WEIGHTS) if units <= s.keys()), None)
        if sizes is None:
            return None
        unit = "kg" if sizes is MASSES else "N"
        numbers = [n * sizes[u or unit] for n, u in zip(numbers, spelled, strict=True)]
    return Entry(
        file_name=names.expression, unit=unit, sure="likely", why="the files' names",
        names={word: f"{n:.10g}" for word, n in zip(names.middle, numbers, strict=True)},
    )  # fmt: skip


def _among_words(names: Names) -> Entry | None:
    """Loads in names of files that say more: a weight with its unit each, ``500g_run2``."""
    found = [
        IN_WORDS.findall(re.sub(r"_", " ", names.head + word + names.tail)) for word in names.middle
    ]
    weighed = [one for one in found if len(one) == 1]
    if len(weighed) < len(found) or len({number for ((number, _),) in weighed}) < 2:
        return None
    units = [known_unit(unit) or "" for ((_, unit),) in weighed]
    sizes = next((s for s in (MASSES, WEIGHTS) if set(units) <= s.keys()), None)
    if sizes is None:
        return None
    loads = [float(n.replace(",", ".")) * sizes[u] for ((n, _),), u in zip(weighed, units,
                                                                          strict=True)]  # fmt: skip
    return Entry(
        file_name=names.expression, unit="kg" if sizes is MASSES else "N", sure="likely",
        why="a weight in each file's name",
        names={word: f"{n:.10g}" for word, n in zip(names.middle, loads, strict=True)},
    )  # fmt: skip


def by_letters(words: Sequence[str]) -> list[str]:
    """Left and right of two words that differ by their first letter alone; empty for others."""
    if len(words) != 2 or words[0][1:] != words[1][1:]:
        return []
    first, second = (word[:1].lower() for word in words)
    if first + second in _PAIRS:
        return ["left", "right"]
    return ["right", "left"] if second + first in _PAIRS else []


def whole_name(names: Sequence[str]) -> str:
    """The expression that takes whole names, with their folders where these tell them apart."""
    return "^(.+/.+)$" if any("/" in name for name in names) else "^(.+)$"


def escaped(name: str) -> str:
    """A name as a pattern of names."""
    return re.sub(r"[\[\]*]", "?", name)
