"""Files that are no tables yet: by their suffix, or messages printed as text."""

from __future__ import annotations

import ast
import json
import re
from collections import Counter

from footcal_cli.tables.pose_blocks import begins_with_poses
from footcal_cli.tables.turns import TURNS, take_turns

READERS = {
    ".bag": "bags", ".db3": "bags", ".mcap": "mcap_files", ".c3d": "c3d", ".mot": "opensim",
    ".sto": "opensim", ".mat": "matlab", ".h5": "hdf5", ".hdf5": "hdf5", ".hdf": "hdf5",
    ".jsonl": "lines", ".ndjson": "lines", ".json": "lines", ".csv": "logs", ".tsv": "logs",
    ".txt": "logs", ".prom": "logs", ".lvm": "logs", ".npz": "arrays_numpy", ".npy": "arrays_numpy",
    ".log": "logs", ".yaml": "documents", ".yml": "documents", ".xml": "records",
    ".ini": "logs", ".toml": "logs", ".parquet": "logs", ".pq": "logs", ".html": "webpages",
    ".htm": "webpages",
}  # fmt: skip
"""Suffix -> module of the room `formats` that makes tables of such a file."""
END_OF_HEADER = "***End_of_Header***"
SEGMENTS = "segments with a header each (LabVIEW)"
BLOCKS = "blocks of lines, a rotation matrix in each"
_BLOCK = re.compile(r"(?m)^(\s*)([A-Za-z_]\w*) \{[ \t]*$")
_CLOSED = re.compile(r"(?m)^\s*\}[ \t]*\n")
_BETWEEN = re.compile(r"\n[ \t]*\n")
_FEWEST_BLOCKS = 2
_ONE_SEGMENT = 2
"""Headers of a LabVIEW file of one segment: the file's and the segment's."""


_CARD_LINE = re.compile(r"^\s*([^\W\d][^:=\[\]{}<>|]{0,40}?)\s*[:=]\s*(\S.*?)\s*$")
_TITLE = re.compile(r"^\s*(?:\[+[^\]]*\]+|[-=*_#]{3,}.*)\s*$")
_FEWEST_CARDS, _ALIKE = 3, 0.8


def cards(text: str) -> list[dict[str, str]]:
    """Records of lines ``key: value``, a new one where a key comes again; empty for other texts.

    Most of them have the same keys, two at least; what stands above the first of these is left out.
    """
    found: list[dict[str, str]] = [{}]
    taken = written = 0
    for line in text.splitlines():
        if not line.strip() or _TITLE.match(line):
            continue
        written += 1
        if (pair := _CARD_LINE.match(line)) is None:
            continue
        taken += 1
        if pair[1] in found[-1]:
            found.append({})
        found[-1][pair[1]] = pair[2]
    if not written or taken < _ALIKE * written:
        return []
    keys = Counter(frozenset(one) for one in found)
    most, count = keys.most_common(1)[0]
    if count < max(_FEWEST_CARDS, _ALIKE * len(found) - 1) or len(most) < 2:
        return []
    return [{k: v for k, v in one.items() if k in most} for one in found if most <= one.keys()]


def is_of_cards(text: str) -> bool:
    """Whether a text is of records of lines ``key: value``."""
    return bool(cards(text))


def _literal(text: str) -> str:
    """``JSON`` where a text begins with an object in it, ``Python`` where it is one of that.

    Alone, or as the first of a list.
    """
    start = text.lstrip().removeprefix("[").lstrip()
    if not start.startswith("{"):
        return ""
    try:
        json.JSONDecoder().raw_decode(start)
    except ValueError:
        pass
    else:
        return "JSON"
    try:
        said = ast.literal_eval(text.strip())
    except (ValueError, SyntaxError, MemoryError, RecursionError):
        return ""
    return "Python" if isinstance(said, dict | list) else ""


def kind_of_records(text: str) -> str:
    """JSON, Python, HTML, XML or YAML where a text is records in it, `BLOCKS`; empty for others."""
    if kind := _literal(text):
        return kind
    if begins_with_poses(text):
        return BLOCKS
    if take_turns(text):
        return TURNS
    if text.startswith("LabVIEW Measurement") and text.count(END_OF_HEADER) > _ONE_SEGMENT:
        return SEGMENTS
    if re.match(r"\s*<(?:!doctype html|html|table)\b", text, re.IGNORECASE):
        return "HTML"
    if is_xml(text):
        return "XML"
    lines = [line for line in text.splitlines()[:400] if line.strip()]
    entries = [
        line for line in lines if re.match(r"\s*- +(?:\{|[\w\"'][\w .\"'-]*:(?:\s|$))", line)
    ]
    keyed = sum(bool(re.match(r"\s*(?:- +)?[\w\"'][\w .\"'-]*:(?:\s|$)", line)) for line in lines)
    braced = sum(line.lstrip().startswith("- {") for line in lines)
    return "YAML" if len(entries) >= 2 and keyed + braced > 0.8 * len(lines) else ""


def is_xml(text: str) -> bool:
    """Whether a text begins with an element of XML that some tag closes, or with what says so."""
    begins = re.match(r"\s*<(?:\?xml\b|!--|[A-Za-z_][\w:.-]*[\s>/])", text)
    return begins is not None and re.search(r"</|/>|<\?xml|<!--", text) is not None


def without_braces(text: str) -> str:
    """Messages as `gz topic -e` prints them, in the form of `ros2 topic echo`.

    ``force {`` becomes ``force:``, and the empty line between two messages ``---``. Messages
    without a line between them, each of which begins with the same key, get one.
    """
    key = re.match(r"\s*^([A-Za-z_]\w*:)[ \t]*$", text, re.MULTILINE)
    if key and "\n---" not in text:
        again = re.compile(rf"(?m)(?<=\n)(?={re.escape(key[1])}[ \t]*$)")
        return again.sub("---\n", text) + "\n---\n" if again.search(text) else text
    if len(_BLOCK.findall(text[:20_000])) < _FEWEST_BLOCKS or not _CLOSED.search(text):
        return text
    plain = _CLOSED.sub("", _BLOCK.sub(r"\1\2:", text))
    return _BETWEEN.sub("\n---\n", plain)


def is_one_message(text: str) -> bool:
    """Whether a text is a single message of a force along three axes, its keys with colons."""
    lines = [line for line in text.splitlines() if line.strip() and line.strip() != "---"]
    keyed = all(re.match(r"\s*[A-Za-z_]\w*:(?:\s|$)", line) for line in lines)
    return keyed and sum(line.strip().startswith("force:") for line in lines) == 1


def is_of_documents(text: str) -> bool:
    """Whether a text is of messages: keys with colons, ``---`` between, or blocks in braces."""
    lines = [line for line in without_braces(text).splitlines()[:400] if line.strip()]
    ends = sum(line.strip() == "---" for line in lines)
    keyed = sum(bool(re.match(r"\s*(?:- )?[A-Za-z_]\w*:(?:\s|$)", line)) for line in lines)
    return ends >= 2 and keyed > 0.5 * (len(lines) - ends)
