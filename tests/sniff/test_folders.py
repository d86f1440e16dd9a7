"""``init`` of a folder: its logs, its notes, and what is neither."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from footcal_cli.sniff.notes import notes_among
from tests.conftest import Run

NOTES = """Cells under the plate, measured with a caliper by us in June:
The robot weighs 24.3 kg with its battery, on the scale of the workshop.
Nothing was changed between the two runs of that morning, as far as we know.
"""


def bench(path: Path) -> None:
    rows = (f"{kg},{round(8000 - 700 * kg)}" for kg in (0, 1, 2, 5, 10, 5, 2, 1, 0))
    path.write_text("\n".join(["load_kg,counts", *rows]) + "\n")


def test_a_folder_is_the_logs_and_notes_in_it(tmp_path: Path, run: Run) -> None:
    lab = tmp_path / "lab"
    (lab / "raw").mkdir(parents=True)
    bench(lab / "raw" / "bench.csv")
    (lab / "NOTES.txt").write_text(NOTES)
    (lab / "photo.png").write_bytes(b"\x89PNG")
    (lab / ".hidden.csv").write_text("a,b\n1,2\n")
    (lab / "todo.csv").write_text("call,the workshop\norder,two more cells\n")
    done = run("init", lab, "-o", tmp_path / "r.toml")
    assert done.exit_code == 0, done.err
    assert "load_kg -> load_n in kg" in done.out
    assert "NOTES.txt: read as notes" in done.out
    assert "todo.csv: left out, no table of numbers" in done.out
    assert ".hidden" not in done.out


def test_a_folder_without_a_log_says_so(tmp_path: Path, run: Run) -> None:
    (tmp_path / "photo.png").write_bytes(b"\x89PNG")
    done = run("init", tmp_path, "-o", tmp_path / "r.toml")
    assert done.exit_code == 2
    assert "holds no log" in done.err


def test_plain_text_is_notes_where_it_is_written_and_no_log(tmp_path: Path) -> None:
    log, notes, listed = (tmp_path / name for name in ("a.csv", "NOTES.txt", "log.txt"))
    bench(log)
    bench(listed)
    notes.write_text(NOTES)
    assert notes_among([log, notes, listed]) == [notes]


@pytest.mark.parametrize(
    ("names", "legs"),
    [
        (("zampa_as", "zampa_ad", "zampa_ps", "zampa_pd"), ("as", "ad", "ps", "pd")),
        (("noga_LP", "noga_PP", "noga_LT", "noga_PT"), ("lp", "pp", "lt", "pt")),
        (("leg_1", "leg_2", "leg_3"), ("leg_1", "leg_2", "leg_3")),
    ],
)
def test_files_called_after_legs_in_any_language_are_legs(
    tmp_path: Path, run: Run, names: tuple[str, ...], legs: tuple[str, ...]
) -> None:
    rng = np.random.default_rng(6)
    for name in names:
        q = rng.standard_normal((30, 4))
        q /= np.linalg.norm(q, axis=1)[:, None]
        w, x, y, z = q.T
        down = np.column_stack([2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x**2 + y**2)])
        force = -48.0 * down + 0.05 * rng.standard_normal((30, 3))
        torque = np.cross([0.01, 0.02, 0.12], -48.0 * down)
        table = np.column_stack([np.arange(30.0), q, force, torque])
        head = "nr,qw,qx,qy,qz,Fx_N,Fy_N,Fz_N,Mx_Nm,My_Nm,Mz_Nm"
        np.savetxt(tmp_path / f"{name}.csv", table, delimiter=",", header=head, comments="")
    done = run("init", tmp_path, "-o", tmp_path / "r.toml")
    assert done.exit_code == 0, done.err
    assert f"{len(names)} six-axis transducers" in done.out
    text = (tmp_path / "r.toml").read_text(encoding="utf-8")
    assert all(f'= "{leg}"' in text for leg in legs)
