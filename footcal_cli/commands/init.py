"""``footcal init``: a recipe for logs of unknown origin, every guess with how sure it is."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from footcal_cli.commands.options import Overwrite, Quiet

if TYPE_CHECKING:
    from footcal_cli.errors import FootcalError


def looks_like(error: FootcalError) -> tuple[str, tuple[str, ...]]:
    """What a log that was refused for its columns looks like, and lines that would be taken.

    Both are empty where nothing can be guessed.
    """
    from footcal_cli.sniff.hint import hint

    found = hint(Path(error.file)) if error.file is not None else None
    return found if found is not None else ("", error.example)


def _as_tables(paths: list[Path], output: Path, *, overwrite: bool) -> tuple[list[Path], list[str]]:
    """Logs with those of other tools as Parquet in a folder next to the recipe, and lines on it."""
    from footcal_cli.commands.convert import ConvertOptions
    from footcal_cli.formats.detect import open_source
    from footcal_cli.formats.into_tables import jobs_of, targets_of, write_tables
    from footcal_cli.sniff.folders import CONVERTED

    foreign = [path for path in paths if path.suffix.lower() in CONVERTED]
    if not foreign:
        return paths, []
    options = ConvertOptions()
    jobs = jobs_of({path: open_source(path, options.time) for path in foreign}, options)
    targets = targets_of(jobs, output.with_name(f"{output.stem}_logs"), overwrite)
    said = write_tables(jobs, targets, options)
    return [*(path for path in paths if path not in foreign), *targets], said


def init(
    logs: Annotated[
        list[Path],
        typer.Argument(metavar="LOG", help="Logs as they are, and notes; or their folder."),
    ],
    output: Annotated[
        Path, typer.Option("--output", "--out", "-o", metavar="FILE.toml", help="Recipe to write.")
    ] = Path("recipe.toml"),
    overwrite: Overwrite = False,
    quiet: Quiet = False,
) -> None:
    """Guess what logs of any layout hold and write a commented recipe for them."""
    from footcal_cli.errors import DataError, UsageError
    from footcal_cli.records.results import AnswerRecord
    from footcal_cli.session.answer import as_json, print_answer
    from footcal_cli.sniff.experiment import why_not
    from footcal_cli.sniff.folders import guessed, in_folders
    from footcal_cli.sniff.hint import accepted
    from footcal_cli.sniff.listing import listing
    from footcal_cli.sniff.notes import notes_among, with_notes
    from footcal_cli.sniff.recipe_text import next_step, recipe_text
    from footcal_cli.sniff.several import parts_of
    from footcal_cli.sniff.unfit import unfit

    if output.exists() and not overwrite:
        raise UsageError(
            "the file is there already", file=output, remedy="name another with -o, or --overwrite"
        )
    if output.suffix.lower() != ".toml":
        raise UsageError("a recipe ends in .toml", file=output, remedy="name it so")
    paths, said_first = _as_tables(in_folders(logs), output, overwrite=overwrite)
    notes = notes_among(paths)
    files, none = guessed([path for path in paths if path not in notes], logs)
    parts, others = parts_of(with_notes(files, notes))
    if not parts and (why := why_not(others[0])) is not None:
        raise DataError(why[0], file=others[0].path, remedy=why[1])
    if not parts:
        message, remedy = unfit(others[0])
        raise DataError(
            message, file=others[0].path, remedy=remedy, example=accepted("weights")
        )  # fmt: skip
    text = recipe_text(parts, output, f"--recipe {output}")
    output.parent.mkdir(parents=True, exist_ok=True)
    waiting = output.with_name(f".{output.name}.partial-{os.getpid()}")
    try:
        waiting.write_text(text, encoding="utf-8")
        waiting.replace(output)
    finally:
        waiting.unlink(missing_ok=True)
    said = next_step(parts, f"--recipe {output}")
    if as_json():
        print_answer(AnswerRecord(command="init", exit_code=0, recipe=str(output), next_step=said))
    if quiet or as_json():
        return
    typer.echo("\n".join([*said_first, *listing(parts)]))
    for other in (o for o in others if o.path not in notes):
        typer.echo(f"{other.path.name}: left out, its columns fit no experiment")
    for path in none:
        typer.echo(f"{path.name}: left out, no table of numbers")
    for path in notes:
        typer.echo(f"{path.name}: read as notes")
    typer.echo(f"recipe: {output}")
    typer.echo(f"next: {said}")
    if not all(part.plan.ready for part in parts):
        typer.echo(f"as it is: footcal check --recipe {output}")
