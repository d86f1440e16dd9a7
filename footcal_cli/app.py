"""The Typer app: the list of commands, and the one place where errors become exit codes."""

from __future__ import annotations

import os
import sys
import traceback
from collections.abc import Callable
from contextlib import ExitStack
from importlib import import_module
from typing import Any, NoReturn

import typer
from typer.core import TyperGroup

from footcal_cli.commands.helptexts import GROUP_OF, JSON_ANSWERS, epilog_of
from footcal_cli.errors import FootcalError, UsageError, lacks_memory, of_machine
from footcal_cli.session.answer import answers, print_refusal
from footcal_cli.session.interruption import Interruption, watched
from footcal_cli.session.run_folder import claims

EXIT_BUG = 70
EXIT_PIPE = 141

COMMANDS = {
    "offline-fit": "Fit load cells to known weights, and a foot's CoP to weights over known holes.",
    "apply": "Turn a log into calibrated forces, centres of pressure or foot wrenches.",
    "batch": "Run one command on many sessions and compare them over dates and robots.",
    "check": "Look for what is wrong with a log and against its recipe; draw the log.",
    "convert": "Convert bags, MCAP, C3D, OpenSim, MATLAB, HDF5 and JSON to Parquet, sheets to CSV.",
    "diagnose": "Say what the model gets wrong: name its cause, extend the model, state the gain.",
    "static-init": "Find scales and biases of foot cells as far as quiet standing shows them.",
    "hang-calib": "Fit offsets of six-axis transducers, and weight and CoM of leg or tool below.",
    "pose-calib": "Fit the mounting of hip transducers, or new offsets, from standing poses.",
    "simulate": "Simulate an experiment with any effects; write its logs and its truth.",
    "effects": "Print the table of effects, or one effect's formula, look-alikes and remedy.",
    "export": "Write a calibration for ROS, mc_rtc, YARP, URDF, C or MATLAB.",
    "init": "Guess what logs of any layout hold and write a commented recipe for them.",
    "kinematics": "Compute CoM, its motion and foot poses from joint angles and base orientation.",
    "online-replay": "Track scales and biases of foot sensors along a recorded walk.",
    "schema": "Print the JSON Schema of a record, or the names of all records.",
}
"""Each command with its sentence in ``--help``; its module is imported when it is asked for."""


def function_of(name: str) -> Callable[..., None]:
    """The function of a command, which bears its name, as its module does."""
    word = name.replace("-", "_")
    function: Callable[..., None] = getattr(import_module(f"footcal_cli.commands.{word}"), word)
    return function


class _Commands(TyperGroup):
    """The commands as stubs that show a name and a sentence; the one asked for is imported."""

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        if args and args[0] in COMMANDS:
            one = typer.Typer(add_completion=False)
            one.command(args[0], epilog=epilog_of(args[0]))(function_of(args[0]))
            self.commands[args[0]] = typer.main.get_command(one)
        return super().resolve_command(ctx, args)


app = typer.Typer(
    name="footcal",
    cls=_Commands,
    help="Calibrate robots that feel the ground: foot load cells and six-axis transducers.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)
for _name, _sentence in COMMANDS.items():
    app.command(_name, help=_sentence, rich_help_panel=GROUP_OF.get(_name))(lambda: None)


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
    json: bool = typer.Option(False, "--json", help="Answer with one JSON on stdout."),
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
    as_json = "--json" in given
    plain = [word for word in given if word not in ("--debug", "--json")]
    given = (["--debug"] if debug else []) + plain
    command = next((word for word in plain if word in COMMANDS), "")
    answered = answers.set([] if as_json else None)
    try:
        with watched() as interruption:
            try:
                with ExitStack() as stack:
                    token = claims.set(stack)
                    try:
                        _refuse_json(command, as_json)
                        app(given, prog_name="footcal")
                    finally:
                        claims.reset(token)
            except BaseException as error:
                _end(error, interruption, debug, command)
    finally:
        answers.reset(answered)


def _refuse_json(command: str, as_json: bool) -> None:
    if as_json and command not in JSON_ANSWERS:
        raise UsageError(f"{command or 'footcal'} has no JSON answer", remedy="leave --json out")


def _end(error: BaseException, interruption: Interruption, debug: bool, command: str) -> NoReturn:
    """Say in one line how a command ended, and exit with the code of its kind."""
    if interruption.signal is not None or isinstance(error, KeyboardInterrupt):
        _fail("footcal: interrupted, nothing half-written", interruption.exit_code, command)
    if isinstance(error, SystemExit):
        if error.code not in (0, None) and answers.get() == []:
            print_refusal(
                command, int(error.code or 0), "the command line cannot be followed: stderr"
            )
        raise error
    if debug:
        if not isinstance(error, FootcalError | OSError) and not lacks_memory(error):
            raise error
        traceback.print_exception(error)
    if isinstance(error, BrokenPipeError):
        # whoever read our output has heard enough; Python must not flush into the pipe again
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        raise SystemExit(EXIT_PIPE)
    if isinstance(error, OSError) or lacks_memory(error):
        error = of_machine(error)
    if isinstance(error, FootcalError):
        guess, example = "", error.example
        if error.foreign:
            from footcal_cli.commands.init import looks_like

            guess, example = looks_like(error)
        said = f"{error.line().rstrip('.')}; {guess}" if guess else error.line()
        _fail(f"footcal: error: {said}", error.exit_code, command, example)
    _fail(
        f"footcal: internal error: {type(error).__name__}: {error} "
        "(this is our bug; run again with --debug and report it)",
        EXIT_BUG,
        command,
    )


def _fail(message: str, exit_code: int, command: str, example: tuple[str, ...] = ()) -> NoReturn:
    line = " ".join(message.split())
    typer.echo(line, err=True)
    if answers.get() is not None:
        print_refusal(command, exit_code, line)
    if example:
        typer.echo("\n".join(("for example:", *(f"  {line}" for line in example))), err=True)
    raise SystemExit(exit_code)
