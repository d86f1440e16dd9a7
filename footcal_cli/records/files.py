"""What every record is: versioned JSON that cannot be misread, and the strict reader."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Literal, TypeVar

from pydantic import ConfigDict, Field, ValidationError

from footcal_cli import __version__
from footcal_cli.errors import UsageError, nearest
from footcal_cli.records.models import Frozen
from footcal_cli.tables.textfiles import read_text


class Record(Frozen):
    """Frozen, strict about keys, and free of NaN: an absent number is null."""


class Versioned(Record):
    """A record that stands in a file of its own."""

    model_config = ConfigDict(
        frozen=True, extra="forbid", allow_inf_nan=False, serialize_by_alias=True
    )

    schema_name: str = Field(alias="schema")
    schema_version: Literal[1] = 1
    footcal_version: str = __version__


LARGEST_BYTES = 64 * 2**20
"""No record is larger; a larger file is something else."""

AnyVersioned = TypeVar("AnyVersioned", bound=Versioned)


def write_record(record: Versioned, path: Path) -> None:
    """Write a record as indented JSON with a final newline."""
    path.write_text(record.model_dump_json(indent=2, by_alias=True) + "\n", encoding="utf-8")


def read_record(model: type[AnyVersioned], path: Path) -> AnyVersioned:
    """Read a record strictly.

    Raises
    ------
    UsageError
        No such file, not JSON, another schema, a newer version, or a key or value that does not
        belong there.
    """
    text = read_text(path, at_most=LARGEST_BYTES)
    try:
        content = json.loads(text)
    except RecursionError:
        raise UsageError("nested too deeply", file=path, remedy="write it again") from None
    except ValueError as error:  # not JSON, or a number of thousands of digits
        raise UsageError(f"not valid JSON: {error}", file=path, remedy="write it again") from None
    expected = str(model.model_fields["schema_name"].default)
    found = content.get("schema") if isinstance(content, dict) else None
    if found != expected:
        raise UsageError(
            f"schema is '{found}', expected '{expected}'", file=path,
            remedy="give the file that footcal wrote",
        )  # fmt: skip
    version = content.get("schema_version")
    if isinstance(version, int) and version > 1:
        raise UsageError(
            f"schema version {version} is newer than this footcal ({__version__}) reads",
            file=path, remedy="update footcal",
        )  # fmt: skip
    try:
        return model.model_validate_json(text, strict=True)
    except ValidationError as error:
        fault = error.errors()[0]
        key = ".".join(str(part) for part in fault["loc"])
        hint = ""
        if fault["type"] == "extra_forbidden":
            hint = nearest(key, [f.alias or n for n, f in model.model_fields.items()])
        problem = fault["msg"].removeprefix("Value error, ")
        raise UsageError(
            f"key '{key}': {problem}{hint}" if key else problem, file=path,
            remedy="write it with footcal",
        ) from None  # fmt: skip
