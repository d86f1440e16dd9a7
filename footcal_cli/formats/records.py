"""Records in YAML or XML: a list of entries that all say the same, one row each.

Room: formats; opened by `footcal_cli.formats.detect` for texts that `footcal_cli.tables.foreign`
recognises.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from footcal_cli.errors import DataError
from footcal_cli.formats.arrays import stream_of
from footcal_cli.formats.contract import Array, ClockOf, Stream, number_of, with_unit
from footcal_cli.tables.foreign import BLOCKS, cards, is_xml
from footcal_cli.tables.pose_blocks import pose_blocks
from footcal_cli.tables.turns import rows_of_turns
from footcal_cli.tables.units import SPELLINGS

_LEAST = 2
_ANOTHER_ROOT = 9
"""Expat's code for an element behind the end of the document."""
_DECLARATION = re.compile(r"<\?xml[^>]*\?>|<!DOCTYPE[^>]*>")
_WEIGHED = re.compile(r"([-+]?\d+(?:\.\d+)?)\s*([A-Za-z]{1,4})")
_PAIR = re.compile(r"^(?P<key>\"[^\"]*\"|'[^']*'|[^\s:#\[{][^:]*?)\s*:(?:\s+(?P<value>.*))?$")
_DASH = re.compile(r"^(?P<indent>\s*)-\s+(?P<rest>\S.*)$")


def streams(path: Path, _clock: ClockOf) -> tuple[Stream, ...]:
    """The one table of the records.

    Raises
    ------
    DataError
        No list of entries, or an XML document that breaks off.
    """
    text = path.read_text(encoding="utf-8-sig", errors="replace")
    if found := pose_blocks(text):
        return (stream_of(path.name.split(".")[0], BLOCKS, found),)
    others = _of_xml(path, text) if is_xml(text) else cards(text) or _of_yaml(text)
    rows = rows_of_turns(text) or others
    if len(rows) < _LEAST:
        raise DataError(
            "no list of records", file=path,
            remedy="export one entry for each sample, or a table with its columns named",
        )  # fmt: skip
    kind = "XML records" if is_xml(text) else "records"
    return (table_of(path.name.split(".")[0], kind, rows),)


def table_of(name: str, kind: str, rows: Sequence[Mapping[str, str]]) -> Stream:
    """A stream of rows of texts by column; numbers where all texts of a column are some."""
    names = list(dict.fromkeys(name for row in rows for name in row))
    columns = dict(_with_its_unit(n, [row.get(n, "") for row in rows]) for n in names)
    return stream_of(name, kind, columns)


def _with_its_unit(name: str, words: Sequence[str]) -> tuple[str, Array]:
    """A column and its name; a unit that stands behind all its numbers stands behind the name."""
    parted = [_WEIGHED.fullmatch(word.strip()) for word in words]
    units = {found[2] for found in parted if found}
    if len(units) != 1 or not all(parted) or units.isdisjoint(SPELLINGS):
        return name, _column(words)
    return with_unit(name, units.pop()), _column([found[1] for found in parted if found])


def _column(words: Sequence[str]) -> Array:
    """Numbers where all words are some or are empty, else the words."""
    numbers = [number_of(word) for word in words]
    if all(n is not None or not w.strip() for n, w in zip(numbers, words, strict=True)):
        if all(isinstance(n, int) for n in numbers):
            return np.array(numbers, dtype=np.int64)
        return np.array([np.nan if n is None else n for n in numbers], dtype=np.float64)
    return np.array(words, dtype=object)


def _of_xml(path: Path, text: str) -> list[dict[str, str]]:
    """The elements that most others are like, with what their parents say."""
    try:
        root = ElementTree.fromstring(text)
    except ElementTree.ParseError as error:
        if error.code == _ANOTHER_ROOT and not text.startswith("<all>"):
            return _of_xml(path, f"<all>{_DECLARATION.sub('', text)}</all>")  # telegrams in a row
        raise DataError(
            f"not valid XML (truncated?): {error}", file=path, remedy="export it again"
        ) from None
    found = list(_elements(root, {}))
    # a record says something: the most numerous of the outermost that do
    tags = Counter(element.tag for element, _ in found if len(element) or element.attrib)
    if not tags:
        return []
    most = tags.most_common(1)[0][1]
    record = next(e.tag for e, _ in found if tags[e.tag] == most)
    return [{**above, **_said(e, "")} for e, above in found if e.tag == record]


def _elements(
    element: ElementTree.Element, above: Mapping[str, str]
) -> Iterator[tuple[ElementTree.Element, Mapping[str, str]]]:
    yield element, above
    tag = _plain(element.tag)
    own = {f"{tag}.{_plain(name)}": value for name, value in element.attrib.items()}
    for child in element:
        yield from _elements(child, {**above, **own})


def _said(element: ElementTree.Element, prefix: str) -> dict[str, str]:
    """Attributes and texts of an element and those in it, by dotted names."""
    said = {prefix + _plain(name): value for name, value in element.attrib.items()}
    if (element.text or "").strip() and not len(element):
        said[prefix.rstrip(".") or _plain(element.tag)] = (element.text or "").strip()
    twice = Counter(child.tag for child in element)
    seen: Counter[str] = Counter()
    for child in element:
        number = f"_{seen[child.tag]}" if twice[child.tag] > 1 else ""
        seen[child.tag] += 1
        said |= _said(child, f"{prefix}{_plain(child.tag)}{number}.")
    return said


def _plain(tag: str) -> str:
    """A tag without its name space."""
    return tag.rpartition("}")[2]


def _of_yaml(text: str) -> list[dict[str, str]]:
    """The entries of the longest list, or the lists of one length beside each other."""
    lists: dict[str, list[str]] = {}
    entries: dict[int, list[dict[str, str]]] = {}
    indent, above = -1, [(-1, "")]
    for line in text.splitlines():
        plain = re.sub(r"\s#.*$", "", line).rstrip()
        if not plain.strip() or plain.lstrip().startswith(("#", "---", "%")):
            continue
        dashed = _DASH.match(plain)
        if dashed is not None and (found := _pairs(dashed["rest"])) is not None:
            indent = len(dashed["indent"])
            entries.setdefault(indent, []).append(found[1])
            above = [(indent, found[0])]
            continue
        depth = len(plain) - len(plain.lstrip())
        pair = _PAIR.match(plain.strip())
        if pair is None:
            continue
        key, value = _bare(pair["key"]), (pair["value"] or "").strip()
        if depth <= indent or indent < 0:
            indent = -1 if depth <= indent else indent
            if value.startswith("[") and value.endswith("]"):
                lists[key] = [_bare(word) for word in value[1:-1].split(",")]
            continue
        while above and above[-1][0] >= depth:
            above.pop()
        name = ".".join([part for _, part in above if part] + [key])
        above.append((depth, key if not value else ""))
        if value:
            entries[indent][-1][name] = _bare(value)
    longest = max(entries.values(), key=len, default=[])
    lengths = {len(own) for own in lists.values()}
    if len(lists) > 1 and len(lengths) == 1 and lengths.pop() > len(longest):
        return [dict(zip(lists, row, strict=True)) for row in zip(*lists.values(), strict=True)]
    return longest


def _pairs(text: str) -> tuple[str, dict[str, str]] | None:
    """What stands behind a dash: one pair or several in braces, and the key that opens a map."""
    if text.startswith("{") and text.endswith("}"):
        said = [_PAIR.match(part.strip()) for part in text[1:-1].split(",")]
        return "", {_bare(p["key"]): _bare(p["value"] or "") for p in said if p is not None}
    pair = _PAIR.match(text)
    if pair is None:
        return None
    key, value = _bare(pair["key"]), (pair["value"] or "").strip()
    return ("", {key: _bare(value)}) if value else (key, {})


def _bare(word: str) -> str:
    word = word.strip()
    quoted = len(word) > 1 and word[0] == word[-1] and word[0] in "\"'"
    return word[1:-1] if quoted else word
