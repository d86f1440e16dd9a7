"""The Typer app: the list of commands, and the one place where errors become exit codes."""

from __future__ import annotations

import os
import sys
import traceback

import typer

from footcal_cli.commands.apply import apply
from footcal_cli.commands.check import check
from footcal_cli.commands.convert import convert
from footcal_cli.commands.diagnose import diagnose
from footcal_cli.commands.effects import effects
from footcal_cli.commands.hang_calib import hang_calib
from footcal_cli.commands.offline_fit import offline_fit
from footcal_cli.commands.online_replay import online_replay
from footcal_cli.commands.pose_calib import pose_calib
from footcal_cli.commands.schema import schema
from footcal_cli.commands.simulate import simulate
from footcal_cli.commands.static_init import static_init
from footcal_cli.errors import FootcalError

EXIT_BUG = 70

app = typer.Typer(
    name="footcal",
    help="Calibrate robots that feel the ground: foot load cells and six-axis transducers.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)
app.command("offline-fit")(offline_fit)
app.command("apply")(apply)
app.command("check")(check)
app.command("convert")(convert)
app.command("diagnose")(diagnose)
app.command("static-init")(static_init)
app.command("hang-calib")(hang_calib)
app.command("pose-calib")(pose_calib)
app.command("simulate")(simulate)
app.command("effects")(effects)
app.command("online-replay")(online_replay)
app.command("schema")(schema)


def _show_version(wanted: bool) -> None:
    if wanted:
        from footcal_cli import __version__

        typer.echo(f"footcal {__version__}")
        raise typer.Exit


@app.callback()
def options(
    version: bool = typer.Option(
        False, "--version", callback=_show_version, is_eager=True, help="Print the version."
    ),
    debug: bool = typer.Option(False, "--debug", help="Show tracebacks."),
) -> None:
    """Calibrate robots that feel the ground."""


def main(arguments: list[str] | None = None) -> None:
    """Run the command line; every error leaves as one line and an exit code."""
    # matrices are small here: threads of the linear algebra cost more than they bring
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    given = sys.argv[1:] if arguments is None else list(arguments)
    debug = "--debug" in given
    # --debug works before and behind the command alike
    given = (["--debug"] if debug else []) + [word for word in given if word != "--debug"]
    try:
        app(given, prog_name="footcal")
    except FootcalError as error:
        if debug:
            traceback.print_exc()
        _fail(f"footcal: error: {error.line()}", error.exit_code)
    except KeyboardInterrupt:
        _fail("footcal: interrupted, nothing was written", 130)
    except Exception as error:
        if debug:
            raise
        _fail(
            f"footcal: internal error: {type(error).__name__}: {error} "
            "(this is our bug; run again with --debug and report it)",
            EXIT_BUG,
        )


def _fail(message: str, exit_code: int) -> None:
    typer.echo(" ".join(message.split()), err=True)
    raise SystemExit(exit_code)
