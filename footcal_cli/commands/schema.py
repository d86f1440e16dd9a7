"""``footcal schema``: the JSON Schemas of what footcal writes."""

from __future__ import annotations

from typing import Annotated

import typer


def schema(
    name: Annotated[
        str | None,
        typer.Argument(metavar="RECORD", help="Record to describe: parameters, rmse, run, ..."),
    ] = None,
) -> None:
    """Print the JSON Schema of a record, or the names of all records."""
    import json

    from footcal_cli.errors import UsageError, nearest
    from footcal_cli.records.schemas import SCHEMAS

    if name is None:
        typer.echo("\n".join(SCHEMAS))
        return
    if name not in SCHEMAS:
        raise UsageError(
            f"no record named '{name}'{nearest(name, list(SCHEMAS))}",
            remedy=f"one of {', '.join(SCHEMAS)}",
        )
    typer.echo(json.dumps(SCHEMAS[name].model_json_schema(by_alias=True), indent=2))
