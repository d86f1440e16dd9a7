"""The run folder: nothing of the user's deleted, nothing half-written, one writer at a time."""

from __future__ import annotations

import base64
import hashlib
import html
import json
import os
import re
import resource
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from filelock import FileLock

from footcal_cli.errors import UsageError
from footcal_cli.session.run_folder import (
    GROWN_ROWS,
    GROWN_RUNS,
    claim,
    grown_folder,
    put_in_place,
)
from tests.conftest import REPOSITORY, Run
from tests.faults.forked import AtTouch, count_touches, start

FOOTCAL = [sys.executable, "-m", "footcal_cli"]
LOG = "channel,load_n,counts\n" + "".join(
    f"left_fl,{load},{round(8.3e6 - load / 3.4e-5) + wiggle}\n"
    for load in (0, 10, 20, 30, 40)
    for wiggle in (-20, 0, 30)
)


@pytest.fixture
def log(tmp_path: Path) -> Path:
    path = tmp_path / "weights.csv"
    path.write_text(LOG)
    return path


def files_of(folder: Path) -> set[str]:
    return {p.relative_to(folder).as_posix() for p in folder.rglob("*") if p.is_file()}


def test_a_run_lists_every_file_it_wrote(run: Run, log: Path, tmp_path: Path) -> None:
    assert run("offline-fit", log, "--out", tmp_path / "out").exit_code == 0
    listed = json.loads((tmp_path / "out/run.json").read_text())["files"]
    assert {*listed, "run.json"} == files_of(tmp_path / "out")


def test_overwrite_replaces_what_footcal_wrote(run: Run, log: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    assert run("offline-fit", log, "--out", out).exit_code == 0
    assert run("check", log, "--out", out, "--overwrite").exit_code == 0
    assert not (out / "parameters.json").exists()
    assert sorted(p.name for p in tmp_path.iterdir()) == ["out", "weights.csv"]


def test_overwrite_never_deletes_what_footcal_did_not_write(
    run: Run, log: Path, tmp_path: Path
) -> None:
    mine = tmp_path / "mine"
    mine.mkdir()
    (mine / "notes.txt").write_text("mine")
    answer = run("offline-fit", log, "--out", mine, "--overwrite")
    assert answer.exit_code == 2
    assert "only a folder that footcal wrote" in answer.err
    out = tmp_path / "out"
    assert run("offline-fit", log, "--out", out).exit_code == 0
    (out / "notes.txt").write_text("mine")
    answer = run("offline-fit", log, "--out", out, "--overwrite")
    assert answer.exit_code == 2
    assert "notes.txt" in answer.err
    assert (out / "notes.txt").read_text() == (mine / "notes.txt").read_text() == "mine"


@pytest.mark.parametrize("below", ["", "logs/"])
def test_overwrite_never_deletes_an_input(run: Run, log: Path, tmp_path: Path, below: str) -> None:
    out = tmp_path / "out"
    assert run("offline-fit", log, "--out", out).exit_code == 0
    inside = out / f"{below}weights.csv"
    inside.parent.mkdir(exist_ok=True)
    inside.write_text(LOG)
    answer = run("offline-fit", inside, "--out", out, "--overwrite")
    assert answer.exit_code == 2
    assert "an input of this run" in answer.err
    assert inside.read_text() == LOG


def test_an_input_named_by_the_recipe_is_not_deleted(run: Run, log: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    assert run("offline-fit", log, "--out", out).exit_code == 0
    shutil.copy(log, out / "day1.csv")
    recipe = tmp_path / "r.toml"
    recipe.write_text('[data]\nweights = "out/day*.csv"\n')
    answer = run("offline-fit", "--recipe", recipe, "--out", out, "--overwrite")
    assert answer.exit_code == 2
    assert (out / "day1.csv").read_text() == LOG


def test_the_calibration_to_start_from_is_not_deleted(run: Run, log: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    assert run("offline-fit", log, "--out", out).exit_code == 0
    answer = run(
        "offline-fit", log, "--parameters", out / "parameters.json", "--out", out, "--overwrite"
    )
    assert answer.exit_code == 2
    assert (out / "parameters.json").is_file()


def test_names_are_exchanged_whole(tmp_path: Path) -> None:
    for name in ("new", "out"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "which").write_text(name)
    put_in_place(tmp_path / "new", tmp_path / "out")
    assert (tmp_path / "out/which").read_text() == "new"


def test_a_second_writer_is_refused(run: Run, log: Path, tmp_path: Path) -> None:
    held = FileLock(_lock_of(tmp_path / "out"))
    with held:
        answer = run("offline-fit", log, "--out", tmp_path / "out")
    assert answer.exit_code == 2
    assert "another run is writing" in answer.err
    assert run("offline-fit", log, "--out", tmp_path / "out").exit_code == 0


def _lock_of(out: Path) -> Path:
    import hashlib
    import tempfile

    name = hashlib.sha256(str(out.resolve()).encode()).hexdigest()[:24]
    return Path(tempfile.gettempdir()) / f"footcal-{name}.lock"


def test_leftovers_of_killed_runs_are_removed(run: Run, log: Path, tmp_path: Path) -> None:
    (tmp_path / ".out.partial-abc").mkdir()
    (tmp_path / ".other.partial-abc").mkdir()
    assert run("offline-fit", log, "--out", tmp_path / "out").exit_code == 0
    assert not (tmp_path / ".out.partial-abc").exists()
    assert (tmp_path / ".other.partial-abc").exists()


def test_a_folder_may_be_claimed_again_after_it_was_refused(tmp_path: Path) -> None:
    claim(tmp_path / "free")
    with FileLock(_lock_of(tmp_path / "held")), pytest.raises(UsageError, match="another run"):
        claim(tmp_path / "held")


SIGNALS = pytest.mark.parametrize(
    ("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143), (signal.SIGKILL, -9)]
)


def _nothing_lost(run: Run, log: Path, folder: Path, code: int, said: str) -> None:
    """The earlier run is whole or the new one is; the next run finds nothing in its way."""
    out = folder / "out"
    if code in {130, 143}:
        assert said == "footcal: interrupted, nothing half-written\n"
    listed = json.loads((out / "run.json").read_text())["files"]
    assert {*listed, "run.json"} == files_of(out)
    assert run("offline-fit", log, "--out", out, "--overwrite").exit_code == 0
    assert sorted(p.name for p in folder.iterdir()) == ["out", "weights.csv"]


@pytest.fixture(scope="module")
def touches(tmp_path_factory: pytest.TempPathFactory) -> int:
    """How often a run that replaces another one touches files."""
    folder = tmp_path_factory.mktemp("touched")
    words = overwriting(folder)
    assert start(words, folder.parent / "first.err", drawn=True).wait().code == 0
    return count_touches(words, folder, drawn=True)


def overwriting(folder: Path) -> list[str]:
    log = folder / "weights.csv"
    log.write_text(LOG)
    return ["offline-fit", str(log), "--out", str(folder / "out"), "--overwrite"]


@SIGNALS
@pytest.mark.parametrize("share", [0.02, 0.5, 0.98])
def test_a_signal_at_any_moment_loses_nothing(
    run: Run, tmp_path: Path, touches: int, number: int, code: int, share: float
) -> None:
    """Where files are touched: at the first, in the middle and where names are exchanged."""
    folder = tmp_path / "runs"
    folder.mkdir()
    words = overwriting(folder)
    assert run(*words).exit_code == 0
    at = max(1, round(share * touches))
    struck = AtTouch(folder, at, lambda: os.kill(os.getpid(), number))
    ended = start(words, tmp_path / "said.err", struck.install, drawn=True).wait()
    assert ended.code == code
    _nothing_lost(run, folder / "weights.csv", folder, ended.code, ended.err)


@pytest.mark.parametrize(
    ("number", "code", "after_s"), [(signal.SIGINT, 130, 0.5), (signal.SIGTERM, 143, 1.6)]
)
def test_a_signal_while_a_process_starts_loses_nothing(
    run: Run, log: Path, tmp_path: Path, number: int, code: int, after_s: float
) -> None:
    """Among its imports."""
    out = tmp_path / "out"
    assert run("offline-fit", log, "--out", out).exit_code == 0
    running = subprocess.Popen(
        [*FOOTCAL, "offline-fit", str(log), "--out", str(out), "--overwrite", "--no-pictures"],
        cwd=REPOSITORY, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    time.sleep(after_s)
    running.send_signal(number)
    _, said = running.communicate()
    assert running.returncode in {code, 0}  # 0: it had ended before the signal came
    _nothing_lost(run, log, tmp_path, running.returncode, said)


def test_a_disk_that_is_full_is_the_machine_s_fault(log: Path, tmp_path: Path) -> None:
    """A limit on file sizes stands for the full disk: the same call fails in the same place."""
    folder = tmp_path / "runs"
    folder.mkdir()
    words = ["offline-fit", str(log), "--out", str(folder / "out")]
    done = start(words, tmp_path / "said.err", _small_files, drawn=True).wait()
    assert done.code == 74
    assert done.err.count("\n") == 1
    assert "Remedy:" in done.err
    assert list(folder.iterdir()) == []


def _small_files() -> None:
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (4096, 4096))


def test_a_real_disk_that_is_full(log: Path, tmp_path: Path) -> None:
    """A memory disk smaller than a run folder, where this user may mount one."""
    disk = tmp_path / "disk"
    disk.mkdir()
    mount = ["mount", "-t", "tmpfs", "-o", "size=32k", "none", str(disk)]
    if shutil.which("mount") is None or subprocess.run(mount, capture_output=True).returncode:
        pytest.skip("this user may not mount a disk")
    try:
        words = ["offline-fit", str(log), "--no-pictures", "--out", str(disk / "out")]
        ended = subprocess.run(
            [sys.executable, "-m", "footcal_cli", *words], capture_output=True, text=True,
            env={**os.environ, "PYTHONPATH": str(REPOSITORY)},
        )  # fmt: skip
        assert ended.returncode == 74
        assert ended.stderr.count("\n") == 1
        assert "free space" in ended.stderr
        assert list(disk.iterdir()) == []
    finally:
        subprocess.run(["umount", disk], check=True)


@pytest.mark.skipif(os.geteuid() == 0 and shutil.which("setpriv") is None, reason="root may write")
def test_a_missing_permission_is_the_machine_s_fault(log: Path, tmp_path: Path) -> None:
    closed = tmp_path / "closed"
    closed.mkdir(mode=0o555)
    plain = [] if os.geteuid() else ["setpriv", "--bounding-set", "-all", "--inh-caps", "-all"]
    done = subprocess.run(
        [*plain, *FOOTCAL, "offline-fit", str(log), "--no-pictures", "--out", str(closed / "out")],
        cwd=REPOSITORY, capture_output=True, text=True, check=False,
    )  # fmt: skip
    if done.returncode == 0:
        pytest.skip("this user may write everywhere")
    assert done.returncode == 74
    assert "permission denied" in done.stderr


@pytest.mark.parametrize("option", ["--recipe", "--parameters"])
def test_a_folder_or_an_impossible_name_is_the_user_s_fault(
    run: Run, log: Path, tmp_path: Path, option: str
) -> None:
    for path in (tmp_path, "x" * 300, tmp_path / "weights.csv" / "below"):
        answer = run("offline-fit", log, option, path, "--out", tmp_path / "out")
        assert answer.exit_code == 2
        assert answer.err.count("\n") == 1
    assert not (tmp_path / "out").exists()


def test_the_page_forbids_everything_but_itself(run: Run, log: Path, tmp_path: Path) -> None:
    assert run("offline-fit", log, "--out", tmp_path / "out").exit_code == 0
    page = (tmp_path / "out/report.html").read_text()
    assert "default-src 'none'" in page
    allowed = re.findall(r"'(sha256-[^']+)'", html.unescape(page))
    for kind, digest in zip(("style", "script"), allowed, strict=True):
        (text,) = re.findall(rf"<{kind}>(.*?)</{kind}>", page, re.DOTALL)
        found = base64.b64encode(hashlib.sha256(text.encode("utf-8")).digest()).decode("ascii")
        assert digest == f"sha256-{found}"
    assert "<script src" not in page


def _summary(out: Path, text: str, *names: str) -> None:
    with grown_folder(out) as new:
        for name in names:
            (new / name).parent.mkdir(exist_ok=True)
            (new / name).write_text(text, "utf-8")
        listed = {"schema": "footcal.run", "files": names}
        (new / "run.json").write_text(json.dumps(listed), "utf-8")


def _whole_summary(out: Path) -> str:
    """The text of a summary all of whose files are of one run, with nothing beside them."""
    names = files_of(out)
    assert {*json.loads((out / "run.json").read_text())["files"], "run.json"} == names
    (text,) = {(out / name).read_text("utf-8") for name in names - {"run.json"}}
    return text


@pytest.mark.filterwarnings("ignore:.*multi-threaded:DeprecationWarning")  # that of pytest-xdist
@pytest.mark.parametrize("killed", [True, False])
def test_a_summary_that_is_interrupted_anywhere_is_one_whole_one(
    tmp_path: Path, killed: bool
) -> None:
    """A killed one may be none until the next run claims the folder; a signal waits for its end."""
    for at in range(1, 100):
        out = tmp_path / str(at)
        _summary(out, "earlier", "figures/a.png", "figures/b.png", "report.html")
        number = os.fork()
        if number == 0:
            AtTouch(out, at, lambda: _end_here(killed)).install()
            try:
                _summary(out, "new", "figures/b.png", "figures/c.png", "report.html")
            except KeyboardInterrupt:
                os._exit(1)
            os._exit(0)
        status = os.waitpid(number, 0)[1]
        if killed and not (out / "run.json").exists():
            claim(out)
        shutil.rmtree(out / GROWN_ROWS)
        text = _whole_summary(out)
        if status == 0:
            assert text == "new"
            return
        _summary(out, "next", "report.html")
        assert _whole_summary(out) == "next"
    pytest.fail("it never ends")


def _end_here(killed: bool) -> None:
    if killed:
        os.kill(os.getpid(), signal.SIGKILL)
    raise KeyboardInterrupt


def test_a_folder_that_grows_is_rid_of_what_a_killed_run_left_in_it(tmp_path: Path) -> None:
    for name in (f"{GROWN_ROWS}/.partial-x", f"{GROWN_RUNS}/.a.partial-x", f"{GROWN_RUNS}/a"):
        (tmp_path / "out" / name).mkdir(parents=True)
    (tmp_path / "out" / GROWN_ROWS / ".a.partial-row").touch()
    claim(tmp_path / "out")
    left = {p.relative_to(tmp_path / "out").as_posix() for p in (tmp_path / "out").glob("*/*")}
    assert left == {f"{GROWN_RUNS}/a"}
