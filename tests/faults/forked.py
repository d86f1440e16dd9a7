"""A command in a forked process: with faults injected where it touches files, or killed there."""

from __future__ import annotations

import contextlib
import multiprocessing.util
import os
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NoReturn

from footcal_cli.app import main
from tests.faults.judging import not_drawn

_EVENTS = frozenset({"open", "os.rename", "os.mkdir", "os.remove", "os.rmdir", "os.chmod",
                     "shutil.rmtree", "tempfile.mkdtemp"})  # fmt: skip
_MAKING = frozenset({"os.mkdir", "tempfile.mkdtemp"})
_WRITING = os.O_WRONLY | os.O_RDWR | os.O_CREAT


@dataclass(frozen=True)
class Ended:
    """How a process ended; a negative code is the signal that killed it."""

    code: int
    err: str


@dataclass(frozen=True)
class Started:
    """A process that runs."""

    number: int
    err: Path

    def wait(self) -> Ended:
        """Wait for its end."""
        _, status = os.waitpid(self.number, 0)
        return Ended(os.waitstatus_to_exitcode(status), self.err.read_text("utf-8", "replace"))


def start(
    words: Sequence[str], err: Path, before: Callable[[], None] = lambda: None, *,
    drawn: bool = False,
) -> Started:  # fmt: skip
    """Fork, call `before`, run the command line, its standard error into a file."""
    number = os.fork()
    if number == 0:
        _run(words, err, before, drawn)
    return Started(number, err)


def _run(words: Sequence[str], err: Path, before: Callable[[], None], drawn: bool) -> NoReturn:
    code = 70
    try:
        at = os.open(err, os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
        os.dup2(at, 2)
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
        sys.stdout, sys.stderr = os.fdopen(1, "w"), os.fdopen(2, "w")
        before()
        with contextlib.nullcontext() if drawn else not_drawn():
            main(list(words))
        code = 0
    except SystemExit as end:
        code = end.code if isinstance(end.code, int) else 1
    except BaseException as error:  # what `main` lets through would be a traceback
        os.write(2, f"Traceback: {error!r}\n".encode())
    sys.stderr.flush()
    # as at the end of a process of its own; the exit handlers of the one that forked stay unheard
    multiprocessing.util._exit_function()  # type: ignore[attr-defined]
    os._exit(code)


@dataclass
class AtTouch:
    """Do something when files below a folder are touched for the n-th time.

    Parameters
    ----------
    folder
        Where.
    number
        Which touch, counted from 1.
    action
        May raise.
    writing
        Count only what needs space.
    repeat
        At every touch from then on.
    """

    folder: Path
    number: int
    action: Callable[[], None]
    writing: bool = False
    repeat: bool = False
    seen: int = 0

    def install(self) -> None:
        """From now on; there is no way back, so call it in a process of its own."""
        sys.addaudithook(self._hook)

    def _hook(self, event: str, arguments: tuple[object, ...]) -> None:
        if event not in _EVENTS or not arguments:
            return
        if not str(arguments[0]).startswith(str(self.folder)):
            return
        if self.writing and not (event in _MAKING or (event == "open" and _writes(arguments))):
            return
        self.seen += 1
        if self.seen == self.number or (self.repeat and self.seen > self.number):
            self.action()


def _writes(arguments: tuple[object, ...]) -> bool:
    flags = arguments[2] if len(arguments) > 2 else 0
    return isinstance(flags, int) and bool(flags & _WRITING)


def count_touches(
    words: Sequence[str], folder: Path, *, writing: bool = False, drawn: bool = False
) -> int:
    """How often a command touches files below a folder."""
    note = folder.parent / f"{folder.name}.touches"

    def install() -> None:
        def write(_event: str, _arguments: object) -> None:
            return

        watch = AtTouch(folder, 0, lambda: None, writing)
        watch.install()
        original = os._exit

        def leave(code: int) -> NoReturn:
            note.write_text(str(watch.seen), "utf-8")
            original(code)

        os._exit = leave  # type: ignore[assignment]

    start(words, folder.parent / f"{folder.name}.err", install, drawn=drawn).wait()
    touches = int(note.read_text("utf-8"))
    note.unlink()
    return touches
