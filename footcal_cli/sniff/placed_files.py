"""A file for each placement: a line above its table, its name or a list of files says the hole.

Room: sniff; asked by several. The files are looked at as one table with a row for each of them.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from footcal_cli.sniff.columns import as_it_stands
from footcal_cli.sniff.experiment import plan_of
from footcal_cli.sniff.file_loads import Names
from footcal_cli.sniff.file_names import Part, called
from footcal_cli.sniff.groups import readings, wrenches
from footcal_cli.sniff.guesses import ColumnGuess, FileGuess, numbers_of
from footcal_cli.sniff.hole_sheets import called_in, with_sheet
from footcal_cli.sniff.indexed import rows_of_files
from footcal_cli.sniff.names import NameGuess, name_guess
from footcal_cli.sniff.numbered import numbered
from footcal_cli.sniff.placed import WEIGHT, one_place_each
from footcal_cli.sniff.plan import Entry, extras, load_entry, times
from footcal_cli.sniff.shared_weight import LEAST_CELLS, LEAST_PLACES
from footcal_cli.sniff.tokens import IN_WORDS
from footcal_cli.sniff.units import known_unit

_SAID = re.compile(r"^[\W_]*(?P<key>[^\W\d][^;:=\t,\n]*?)\s*[;:=\t,]\s*(?P<text>\S.*?)[\s\"';,]*$")
"""``# foro;A3``, ``Bohrung: B2``, ``"hole","C1"``: a line above a table that says one thing."""
_QUOTES = "\"' \t"
_UNIT_SAID = re.compile(r"(?i)unit[sàaé]?|unidade?s?|einheit(?:en)?|enhet|eenheid")
_NAMED = ("placement", "repeat", "load", "hole")
_WHY = "a line above each table"


def placed_files(files: Sequence[FileGuess]) -> tuple[list[Part], list[FileGuess]]:
    """Placements in files of their own, and the files that are none of them."""
    groups: dict[object, list[FileGuess]] = {}
    for file in files:
        names = tuple(c.column for c in file.columns)
        groups.setdefault((file.layout, names), []).append(file)
    parts, left = [], list(files)
    for group in groups.values():
        made = _part(group, [f for f in left if all(f is not own for own in group)])
        if made is not None:
            part, used = made
            parts.append(part)
            left = [f for f in left if all(f is not own for own in (*group, *used))]
    return parts, left


def _part(
    group: Sequence[FileGuess], others: Sequence[FileGuess]
) -> tuple[Part, list[FileGuess]] | None:
    """The placements of some files, and the sheets among others that place their holes."""
    first = group[0]
    cells = readings(first)
    if len(group) < LEAST_PLACES or len(cells) < LEAST_CELLS or wrenches(numbered(first)):
        return None
    if first.of("hole", "com", "placement"):
        return None
    names = Names.of(called([file.path for file in group]))
    sheets = [sheet for sheet in others if called_in(sheet)]
    words = [known for sheet in sheets for known in called_in(sheet)]
    loads = first.of("load")
    if loads and not [*_in_names(group, words)]:
        return None
    said = [_said_above(file) for file in group]
    keys = [k for k in said[0] if all(k in own for own in said[1:])]
    columns = [
        column for k in keys
        if (column := _column(k, [own[k] for own in said], words)) is not None
    ]  # fmt: skip
    if not any(c.quantity in ("placement", "hole") for c in columns):
        columns += _in_names(group, words)
    index = None
    if not any(c.quantity in ("placement", "hole") for c in columns):
        index = next((i for f in others if (i := _in_list(f, names, group)) is not None), None)
        columns += index[1] if index is not None else []
    units = {known_unit(own[k]) for own in said for k in own if _UNIT_SAID.fullmatch(k)}
    unit = units.pop() if len(units) == 1 else None
    table = _table(group, unit)
    if loads:  # stacks on one spot in each file: the plan is that of its places
        columns = [c for c in columns if c.quantity in ("placement", "hole")]
    plan = plan_of(replace(first, columns=(*columns, *table), rows=len(group), rate_hz=None))
    if plan is None or plan.role != "placements":
        return None
    used = [] if index is None else [index[0]]
    for sheet in sheets:
        placed = with_sheet(plan, sheet)
        spots = {word for c in columns for word in c.words}
        # cells may stand in it too
        used += [sheet] if placed is not plan and sheet.rows <= max(len(spots), 1) else []
        plan = placed
    own = {c.column: c for c in columns}
    entries = {name: _by_file(e, own, names) for name, e in plan.entries.items()}
    if loads:
        put, asked = load_entry(loads[0])
        whole = {c.column: c for c in first.columns}
        entries = {n: replace(e, column=whole.get(e.column.column, e.column)) if e.column else e
                   for n, e in entries.items()}  # fmt: skip
        entries |= {"load_n": put, **times(first, needed=False)[0], **extras(first)}
        blanks = (*(b for b in plan.blanks if b is not WEIGHT), *asked)
        plan = replace(plan, blanks=blanks)
    kind = f"{plan.kind}, a file for each placement"
    plan = replace(plan, file=first, entries=entries, kind=kind)
    return Part(plan, tuple(file.path for file in group), names.match), used


def _said_above(file: FileGuess) -> dict[str, str]:
    """What lines above a table say, each of one thing."""
    found = (_SAID.match(line) for line in file.text.above)
    return {m["key"].strip(_QUOTES): m["text"].strip(_QUOTES) for m in found if m}


def _column(key: str, texts: list[str], words: Sequence[set[str]]) -> ColumnGuess | None:
    """What such lines say of all files, a row for each; None where it is of no placement."""
    name = name_guess(key)
    if any({*texts} <= known for known in words):
        name = replace(name, quantity="placement")
    if name.quantity not in _NAMED or (len({*texts}) < 2 and name.quantity != "load"):
        return None
    if name.quantity == "placement":
        return _label(key, texts)
    found = [IN_WORDS.fullmatch(text) for text in texts]
    units = {known_unit(m[2]) if m else None for m in found}
    unit = units.pop() if len(units) == 1 else None
    bare = [m[1] if m else text for m, text in zip(found, texts, strict=True)]
    try:
        values = np.array([float(text.replace(",", ".")) for text in bare])
    except ValueError:
        return None
    return ColumnGuess(key, name, unit or name.unit, "likely", _WHY, values)


def _label(key: str, texts: Sequence[str]) -> ColumnGuess:
    words = tuple(dict.fromkeys(texts))
    codes = np.array([words.index(text) for text in texts])
    return ColumnGuess(key, NameGuess("placement"), None, "likely", _WHY, words=words, codes=codes)


def _in_names(group: Sequence[FileGuess], words: Sequence[set[str]]) -> Iterator[ColumnGuess]:
    """Names of holes that a sheet places, where each file is called after one."""
    for known in words:
        plain = {"_".join(re.split(r"[\W_]+", word.lower())): word for word in known}
        stems = ["_".join(re.split(r"[\W_]+", file.path.stem.lower())) for file in group]
        own = [[word for p, word in plain.items() if f"_{p}_" in f"_{stem}_"] for stem in stems]
        if all(len(found) == 1 for found in own) and len({f[0] for f in own}) >= LEAST_PLACES:
            column = _label("hole", [f[0] for f in own])
            yield replace(column, why="the files' names")
            return


def _in_list(
    sheet: FileGuess, names: Names, group: Sequence[FileGuess]
) -> tuple[FileGuess, list[ColumnGuess]] | None:
    """What a list of files says of each: the hole, by its place or name, the weight, the repeat."""
    plain = as_it_stands(sheet)
    for key in plain.columns:
        rows = rows_of_files(key, names, [file.path for file in group])
        if rows is None:
            continue
        at, why = np.array(rows), f"by {sheet.path.name}"
        said = [
            replace(
                c, why=why, values=None if c.values is None else c.values[at],
                codes=None if c.codes is None else c.codes[at],
            )
            for c in plain.of(*_NAMED, "label")
            if c is not key and (c.values is not None or c.codes is not None)
        ]  # fmt: skip
        places = [c.values for c in said if c.quantity == "hole" and c.values is not None]
        if places:
            where = np.nan_to_num(np.stack(places, axis=1))
            points = [c for c in said if c.codes is not None and one_place_each(c, where)]
            called_so = [c.as_quantity("placement", c.sure, why) for c in points[:1]]
            return sheet, called_so + [c for c in said if c.quantity not in ("label", "placement")]
    return None


def _table(group: Sequence[FileGuess], unit: str | None) -> Iterator[ColumnGuess]:
    """Medians of all readings, a row for each file."""
    for cell in readings(group[0]):
        each = [next(c for c in f.columns if c.column == cell.column) for f in group]
        values = np.array([float(np.nanmedian(numbers_of(c))) for c in each])
        yield replace(cell, values=values, unit=cell.unit or unit)


def _by_file(entry: Entry, columns: Mapping[str, ColumnGuess], names: Names) -> Entry:
    """An entry of what lines above the tables say, by the files' names."""
    column = columns.get("" if entry.column is None else entry.column.column)
    if column is None:
        return entry
    if column.codes is not None:
        texts = [column.words[i] for i in column.codes]
    else:
        texts = [f"{v:.10g}" if np.isfinite(v) else "" for v in numbers_of(column)]
    meant = {
        word: entry.names.get(text, text) for word, text in zip(names.middle, texts, strict=True)
    }
    why = entry.why if entry.names else column.why
    return replace(entry, column=None, file_name=names.expression, names=meant, why=why)
