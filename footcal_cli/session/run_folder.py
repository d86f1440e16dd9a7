"""The run folder: claimed by one writer, written under a temporary name, put in place in one step.

What stands under the folder's name is a whole result at every moment: the earlier one or the new
one. Imported by `footcal_cli.session.session` and `footcal_cli.app`.
"""

from __future__ import annotations

import atexit
import ctypes
import errno
import hashlib
import json
import os
import shutil
import sys
import tempfile
from collections.abc import Collection, Iterable, Iterator
from contextlib import ExitStack, contextmanager
from contextvars import ContextVar
from pathlib import Path

from filelock import FileLock, Timeout

from footcal_cli.errors import UsageError

RUN_SCHEMA = "footcal.run"
GROWN_ROWS = "rows"
"""Marks a folder that grows from run to run: what is done so far, a file per session."""
GROWN_RUNS = "sessions"
"""Its run folders, one per session."""
_EARLIER_RUN = ".run.json"
"""The earlier ``run.json`` of such a folder while its summary is replaced; in the new summary."""
_RENAME_EXCHANGE = 2
_AT_FDCWD = -100

claims: ContextVar[ExitStack | None] = ContextVar("claims", default=None)
"""What `footcal_cli.app` closes when a command ends, however it ends."""


def refuse_folder(out: Path, overwrite: bool, inputs: Iterable[Path]) -> None:
    """Refuse a run folder that must not be written.

    Raises
    ------
    UsageError
        It is a file, it is in use without `overwrite`, footcal did not write it or something else
        lies in it, or it holds one of the `inputs`.
    """
    if out.is_file():
        raise UsageError("--out is a file", file=out, remedy="name a folder")
    if not out.is_dir() or not any(out.iterdir()):
        return
    if not overwrite:
        raise UsageError(
            "the output folder is not empty", file=out, remedy="name another --out or --overwrite"
        )
    if out.is_symlink():
        raise UsageError(
            "--overwrite does not replace a symbolic link", file=out,
            remedy="name the folder it points to",
        )  # fmt: skip
    folder = out.resolve()
    for path in inputs:
        if path.resolve().is_relative_to(folder):
            raise UsageError(
                f"--overwrite would delete an input of this run, {path}", file=out,
                remedy="name another --out",
            )  # fmt: skip
    written = _written_files(out / "run.json")
    if written is None:
        raise UsageError(
            "--overwrite replaces only a folder that footcal wrote, and this one has no run.json",
            file=out, remedy="name another --out, or empty the folder yourself",
        )  # fmt: skip
    strange = sorted(_files(out) - written) if written else []
    if strange:
        raise UsageError(
            f"--overwrite would delete {strange[0]}, which footcal did not write", file=out,
            remedy="move it elsewhere, or name another --out",
        )  # fmt: skip


def _files(folder: Path) -> set[str]:
    return {p.relative_to(folder).as_posix() for p in folder.rglob("*") if not p.is_dir()}


def _written_files(record: Path) -> set[str] | None:
    """Files that a ``run.json`` lists, empty for a run before they were listed; None: no run."""
    try:
        run = json.loads(record.read_text(encoding="utf-8"))
    except (FileNotFoundError, NotADirectoryError, ValueError, RecursionError):
        return None
    if not isinstance(run, dict) or run.get("schema") != RUN_SCHEMA:
        return None
    return {"run.json", *map(str, run.get("files", ()))} if run.get("files") else set()


def claim(out: Path) -> None:
    """Keep other runs on this machine from writing the same folder until the command ends.

    The lock lies in the system's temporary folder, so that nothing is left beside the results; the
    system frees it when the process dies. What killed runs left beside the folder is removed.

    Raises
    ------
    UsageError
        Another run is writing there.
    """
    name = hashlib.sha256(str(out.resolve()).encode()).hexdigest()[:24]
    lock = FileLock(Path(tempfile.gettempdir()) / f"footcal-{name}.lock", mode=0o666)
    try:
        lock.acquire(timeout=0)
    except Timeout:
        raise UsageError(
            "another run is writing this folder",
            file=out,
            remedy="wait for it, or name another --out",
        ) from None  # fmt: skip
    stack = claims.get()
    if stack is not None:
        stack.callback(lock.release)
    for leftover in _leftovers(out):
        if leftover.parent == out / GROWN_ROWS:
            _take_in(leftover, out)
        _remove(leftover)


def refuse_grown(out: Path, overwrite: bool, inputs: Iterable[Path]) -> None:
    """As `refuse_folder`, but a folder of rows and sessions may be gone on with.

    Raises
    ------
    UsageError
        It is in use by something else.
    """
    if (out / GROWN_ROWS).is_dir():
        return
    refuse_folder(out, overwrite, inputs)


@contextmanager
def grown_folder(out: Path) -> Iterator[Path]:
    """A folder whose files go into `out`, ``run.json`` last; the others stay.

    While files are replaced there is no ``run.json``: a summary that has one is whole, and nothing
    lies beside it. What a killed run began is ended by the next one when it claims `out`.
    """
    (out / GROWN_ROWS).mkdir(parents=True, exist_ok=True)
    partial = Path(tempfile.mkdtemp(prefix=".partial-", dir=out / GROWN_ROWS))
    try:
        yield partial
    except BaseException:
        _remove(partial)
        raise
    try:
        _take_in(partial, out)
    except BaseException:
        _take_in(partial, out)  # a signal came in between
        raise
    finally:
        if not (partial / "run.json").exists():  # else the next run goes on with it
            _remove(partial)


def _take_in(partial: Path, out: Path) -> None:
    """Replace the summary in `out` by the one in `partial` if that is whole.

    Called again after it was interrupted, it goes on.
    """
    run, new, earlier = out / "run.json", partial / "run.json", partial / _EARLIER_RUN
    listed = _written_files(new)  # written last
    if listed is None:
        return
    if run.exists():
        run.replace(earlier)
    for name in (_written_files(earlier) or set()) - listed:
        (out / name).unlink(missing_ok=True)  # figures of an earlier, longer summary
    for name in sorted(_files(partial) - {run.name, earlier.name}):
        (out / name).parent.mkdir(exist_ok=True)
        (partial / name).replace(out / name)
    new.replace(run)


def scratch() -> Path:
    """A folder for what a long log leaves on its way; gone when the command ends."""
    folder = Path(tempfile.mkdtemp(prefix="footcal-"))
    stack = claims.get()
    remove = atexit.register if stack is None else stack.callback
    remove(shutil.rmtree, folder, ignore_errors=True)
    return folder


def _leftovers(out: Path) -> list[Path]:
    """What killed runs left beside `out`, and among its rows and sessions."""
    if not out.parent.is_dir():
        return []
    starts = (f".{out.name}.partial-", f".{out.name}.old-")
    beside = [p for p in out.parent.iterdir() if p.is_dir() and p.name.startswith(starts)]
    grown = (out / GROWN_ROWS, out / GROWN_RUNS) if (out / GROWN_ROWS).is_dir() else ()
    within = [p for folder in grown for p in folder.glob(".*")]
    return [*beside, *(p for p in within if ".partial-" in p.name or ".old-" in p.name)]


@contextmanager
def whole_folder(out: Path, overwrite: bool, inputs: Collection[Path]) -> Iterator[Path]:
    """A folder that appears under its name only when the block ends well."""
    refuse_folder(out, overwrite, inputs)
    out.parent.mkdir(parents=True, exist_ok=True)
    partial = Path(tempfile.mkdtemp(prefix=f".{out.name}.partial-", dir=out.parent))
    try:
        yield partial
        partial.chmod(0o777 & ~_umask())  # mkdtemp makes folders only their owner can read
        refuse_folder(out, overwrite, inputs)  # it may have changed while the command worked
        put_in_place(partial, out)
    finally:
        # after an exchange this is the earlier result, otherwise what an error left half-written
        _remove(partial)


def _remove(folder: Path) -> None:
    """Remove a folder or a file, to the end even where a signal comes in between."""
    if folder.is_file():
        folder.unlink(missing_ok=True)
        return
    try:
        shutil.rmtree(folder, ignore_errors=True)
    except BaseException:
        shutil.rmtree(folder, ignore_errors=True)
        raise


def put_in_place(new: Path, out: Path) -> None:
    """Give `new` the name `out` in one step; an earlier `out` then stands under the name of `new`.

    Linux exchanges the two names atomically (``renameat2``). Elsewhere an earlier folder is moved
    aside first, and moved back if the second step fails: only a loss of power between the two
    leaves it under its other name.
    """
    if not out.exists():
        new.rename(out)
        return
    if _exchange(new, out):
        return
    aside = Path(tempfile.mkdtemp(prefix=f".{out.name}.old-", dir=out.parent)) / out.name
    out.rename(aside)
    try:
        new.rename(out)
    except BaseException:
        aside.rename(out)
        raise
    shutil.rmtree(aside.parent, ignore_errors=True)


def _exchange(one: Path, other: Path) -> bool:
    """Exchange two names in one step; False where the system cannot."""
    if not sys.platform.startswith("linux"):
        return False
    try:
        renameat2 = ctypes.CDLL(None, use_errno=True).renameat2
    except (OSError, AttributeError):
        return False
    names = (os.fsencode(one), os.fsencode(other))
    if renameat2(_AT_FDCWD, names[0], _AT_FDCWD, names[1], _RENAME_EXCHANGE) == 0:
        return True
    code = ctypes.get_errno()
    if code in {errno.ENOSYS, errno.EINVAL, errno.ENOTSUP}:
        return False  # an old kernel, or a file system without it
    raise OSError(code, os.strerror(code), str(other))


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask
