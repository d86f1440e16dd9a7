"""Files that are no tables yet: by their suffix, or messages printed as text."""

from __future__ import annotations

import re

READERS = {
    ".bag": "bags", ".db3": "bags", ".mcap": "mcap_files", ".c3d": "c3d", ".mot": "opensim",
    ".sto": "opensim", ".mat": "matlab", ".h5": "hdf5", ".hdf5": "hdf5", ".hdf": "hdf5",
    ".jsonl": "lines", ".ndjson": "lines", ".json": "lines", ".csv": "logs", ".tsv": "logs",
    ".txt": "logs", ".npz": "arrays_numpy", ".npy": "arrays_numpy",
    ".log": "logs", ".yaml": "documents", ".yml": "documents", ".parquet": "logs", ".pq": "logs",
}  # fmt: skip
"""Suffix -> module of the room `formats` that makes tables of such a file."""


def is_of_documents(text: str) -> bool:
    """Whether a text is of messages: keys with colons, ``---`` between."""
    lines = [line for line in text.splitlines()[:400] if line.strip()]
    ends = sum(line.strip() == "---" for line in lines)
    keyed = sum(bool(re.match(r"\s*(?:- )?[A-Za-z_]\w*:(?:\s|$)", line)) for line in lines)
    return ends >= 2 and keyed > 0.5 * (len(lines) - ends)
