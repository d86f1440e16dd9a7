"""Frozen models of what people write, and the first fault in it as one line."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any, TypeVar, get_args

from pydantic import BaseModel, ConfigDict, ValidationError
from pydantic.dataclasses import is_pydantic_dataclass, rebuild_dataclass
from pydantic.fields import FieldInfo

from footcal_cli.errors import UsageError, nearest

Model = TypeVar("Model", bound=BaseModel)


WRITTEN = ConfigDict(extra="forbid", allow_inf_nan=False, defer_build=True)
"""Of all that people write; of a dataclass too that the tables are read by."""
UNKNOWN_KEY = ("extra_forbidden", "unexpected_keyword_argument")
"""What pydantic calls a key that a model, or a dataclass, does not know."""


class Frozen(BaseModel):
    """A model that refuses unknown keys and cannot be changed."""

    model_config = ConfigDict(frozen=True, **WRITTEN)


def validated(
    model: type[Model], content: Mapping[str, Any], *, file: Path | None, table: str = ""
) -> Model:
    """Build a model; the first fault becomes one line.

    Raises
    ------
    UsageError
        Names file, key, value and, for an unknown key, the nearest known one.
    """
    try:
        # JSON's strict mode: a text or a boolean is no number, a list may be a tuple
        return model.model_validate_json(json.dumps(content, default=str), strict=True)
    except ValidationError as error:
        fault = error.errors()[0]
        keys = [str(part) for part in fault["loc"]]
        shown = ".".join([table, *keys] if table else keys)
        if fault["type"] in UNKNOWN_KEY:
            known = _known_keys(model, keys[:-1])
            raise UsageError(
                f"unknown key '{shown}'{nearest(keys[-1], known)}", file=file,
                remedy=f"known here: {', '.join(sorted(known))}" if known else None,
            ) from None  # fmt: skip
        problem = fault["msg"].removeprefix("Value error, ")
        raise UsageError(
            f"key '{shown}': {problem}" if shown else problem, file=file,
            value=fault["input"] if not isinstance(fault["input"], dict) else None,
            remedy="correct the value",
        ) from None  # fmt: skip


def _known_keys(model: type[BaseModel], keys: list[str]) -> list[str]:
    """Field names of the model, or the dataclass, that stands at a path of keys."""
    current: Any = model
    for key in keys:
        if _is_model(current):
            field = fields_of(current).get(key)
            current = field.annotation if field is not None else None
        else:  # dict[str, X] or tuple[X, ...]: step into X
            inner = [a for a in get_args(current) if a is not str and a is not ...]
            current = inner[0] if inner else None
        if not isinstance(current, type):
            models = [a for a in get_args(current) if _is_model(a)]
            current = models[0] if len(models) == 1 and not _is_mapping(current) else current
    return list(fields_of(current)) if _is_model(current) else []


def fields_of(model: Any) -> Mapping[str, FieldInfo]:
    """Fields of a model or of a pydantic dataclass."""
    if is_pydantic_dataclass(model):
        rebuild_dataclass(model)
    name = "model_fields" if issubclass(model, BaseModel) else "__pydantic_fields__"
    found: Mapping[str, FieldInfo] = getattr(model, name)
    return found


def _is_model(item: object) -> bool:
    return isinstance(item, type) and (issubclass(item, BaseModel) or is_pydantic_dataclass(item))


def _is_mapping(annotation: object) -> bool:
    return getattr(annotation, "__origin__", None) is dict
