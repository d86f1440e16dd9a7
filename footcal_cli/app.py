"""The Typer app: the list of commands, and the one place where errors become exit codes."""

from __future__ import annotations

import os
import sys
import traceback
from contextlib import ExitStack
from typing import NoReturn

import typer

from footcal_cli.commands.apply import apply
from footcal_cli.commands.check import check
from footcal_cli.commands.convert import convert
from footcal_cli.commands.diagnose import diagnose
from footcal_cli.commands.effects import effects
from footcal_cli.commands.export import export
from footcal_cli.commands.hang_calib import hang_calib
from footcal_cli.commands.init import init, looks_like
from footcal_cli.commands.kinematics import kinematics
from footcal_cli.commands.offline_fit import offline_fit
from footcal_cli.commands.online_replay import online_replay
from footcal_cli.commands.pose_calib import pose_calib
from footcal_cli.commands.schema import schema
from footcal_cli.commands.simulate import simulate
from footcal_cli.commands.static_init import static_init
from footcal_cli.errors import FootcalError, of_machine
from footcal_cli.interruption import Interruption, watched
from footcal_cli.run_folder import claims

EXIT_BUG = 70
EXIT_PIPE = 141

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
app.command("export")(export)
app.command("init")(init)
app.command("kinematics")(kinematics)
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
    with watched() as interruption:
        try:
            with ExitStack() as stack:
                token = claims.set(stack)
                try:
                    app(given, prog_name="footcal")
                finally:
                    claims.reset(token)
        except BaseException as error:
            _end(error, interruption, debug)


def _end(error: BaseException, interruption: Interruption, debug: bool) -> NoReturn:
    """Say in one line how a command ended, and exit with the code of its kind."""
    if interruption.signal is not None or isinstance(error, KeyboardInterrupt):
        _fail("footcal: interrupted, nothing half-written", interruption.exit_code)
    if isinstance(error, SystemExit):
        raise error
    if debug:
        if not isinstance(error, FootcalError | OSError | MemoryError):
            raise error
        traceback.print_exception(error)
    if isinstance(error, BrokenPipeError):
        # whoever read our output has heard enough; Python must not flush into the pipe again
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        raise SystemExit(EXIT_PIPE)
    if isinstance(error, OSError | MemoryError):
        error = of_machine(error)
    if isinstance(error, FootcalError):
        guess, example = looks_like(error) if error.foreign else ("", error.example)
        said = f"{error.line().rstrip('.')}; {guess}" if guess else error.line()
        _fail(f"footcal: error: {said}", error.exit_code, example)
    _fail(
        f"footcal: internal error: {type(error).__name__}: {error} "
        "(this is our bug; run again with --debug and report it)",
        EXIT_BUG,
    )


def _fail(message: str, exit_code: int, example: tuple[str, ...] = ()) -> NoReturn:
    typer.echo(" ".join(message.split()), err=True)
    if example:
        typer.echo("\n".join(("for example:", *(f"  {line}" for line in example))), err=True)
    raise SystemExit(exit_code)
