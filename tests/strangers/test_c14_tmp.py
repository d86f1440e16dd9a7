import pytest
from pathlib import Path
from tests.strangers import fourteenth_bench as b, fourteenth_robots as r
from tests.strangers.trial import trial
from tests.conftest import *
import os

ONLY = os.environ.get("ONLY", "").split()
SH = [s for s in (*b.FOURTEENTH_BENCH, *r.FOURTEENTH_ROBOTS) if not ONLY or s.__name__ in ONLY]


@pytest.mark.parametrize("shape", SH, ids=lambda s: s.__name__)
def test_one(shape, run, tmp_path):
    try:
        f = trial(shape, tmp_path, run)
        out = f.outcome
    except Exception as e:
        out = f"EXC {type(e).__name__} {e}"
        f = None
    with open("/tmp/c14.out", "a") as h:
        h.write(f"{shape.__name__}: {out[:330]}\n")
