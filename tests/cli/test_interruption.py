"""A signal ends the work wherever Python happens to be when it comes."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
import weakref
from pathlib import Path

import pytest

from footcal_cli.session.interruption import Interrupted, watched


class Thing:
    """Something that a weak reference can point at."""


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_in_the_callback_of_a_weak_reference_is_not_lost(
    number: signal.Signals, capfd: pytest.CaptureFixture[str]
) -> None:
    """Python drops exceptions there; the import system has such callbacks."""
    thing = Thing()
    reference = weakref.ref(thing, lambda _: signal.raise_signal(number))
    with watched() as interruption:
        del thing
        assert reference() is None
        with pytest.raises(Interrupted):
            time.sleep(10.0)
    assert interruption.signal == number
    assert capfd.readouterr().err == ""


def test_what_else_goes_wrong_there_is_still_reported(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    reported: list[type[BaseException]] = []
    monkeypatch.setattr("sys.unraisablehook", lambda raised: reported.append(raised.exc_type))
    thing = Thing()
    reference = weakref.ref(thing, lambda _: 1 // 0)
    with watched():
        del thing
    assert reference() is None
    assert reported == [ZeroDivisionError]


_DURING = """
import signal, sys
class Finder:
    def find_spec(self, name, *_):
        if name == "footcal_cli.session.interruption":
            signal.raise_signal({number})
sys.meta_path.insert(0, Finder())
from footcal_cli.__main__ import run
run()
"""


@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_a_signal_during_the_first_imports_ends_in_one_sentence(
    number: signal.Signals, code: int
) -> None:
    done = subprocess.run(
        [sys.executable, "-c", _DURING.format(number=int(number)), "--help"],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == code
    assert done.stdout == ""
    assert done.stderr == "footcal: interrupted, nothing half-written\n"


@pytest.mark.parametrize(("gate_n", "code"), [(10.0, 0), (1e-9, 1)])
def test_a_reader_who_leaves_changes_no_exit_code(tmp_path: Path, gate_n: float, code: int) -> None:
    """``footcal … | head -1`` under ``pipefail``."""
    log = tmp_path / "weights.csv"
    rows = [f"a,{load},{8000 + 300 * load + load % 3}" for load in range(12)]
    log.write_text("\n".join(["channel,load_n,counts", *rows]) + "\n")
    ours, theirs = os.pipe()
    os.close(ours)  # nobody reads
    words = ["offline-fit", log, "--max-rmse-n", gate_n, "--out", tmp_path / "out"]
    done = subprocess.run(
        [sys.executable, "-m", "footcal_cli", *map(str, words), "--no-pictures"],
        stdout=theirs, stderr=subprocess.PIPE, check=False,
    )  # fmt: skip
    os.close(theirs)
    assert done.returncode == code, done.stderr
    assert b"Traceback" not in done.stderr
    assert (tmp_path / "out" / "run.json").exists()
