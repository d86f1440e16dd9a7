"""Pieces of reading that have no other test: cells, texts, names of files and folders, places."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from footcal_cli.commands import option_tables
from footcal_cli.errors import DataError, UsageError
from footcal_cli.formats.detect import open_source
from footcal_cli.recipe import Recipe, read_recipe
from footcal_cli.tables.canonical_names import is_canonical
from footcal_cli.tables.carried import Carried
from footcal_cli.tables.columns import cells_table, weights_stream_table, weights_table
from footcal_cli.tables.delimited import before_power_was_lost, text_names, text_table
from footcal_cli.tables.foreign import is_of_documents
from footcal_cli.tables.logfiles import column_names, raw_columns, unpacked
from footcal_cli.tables.longfiles import raw_pieces
from footcal_cli.tables.places import places_of
from footcal_cli.tables.reading import BLANKS, ForeignColumn, Layout, Reading
from footcal_cli.tables.table import Table, read_table
from footcal_cli.tables.textfiles import called_as, regular_file
from footcal_cli.tables.values import bare_hexadecimal

G = 9.80665


def recipe(folder: Path, text: str) -> Recipe:
    path = folder / "r.toml"
    path.write_text(text, encoding="utf-8")
    return read_recipe(path, option_tables())


@pytest.mark.parametrize(
    ("words", "is_hexadecimal"),
    [
        (["7FFE3A", "7F0012"], True), (["7ffe3a", "100000"], True),
        (["123456", "654321"], False),  # numbers
        (["7FFE3A", "7F00"], False), (["FEED", "good"], False),
        (["ABC", "ABD"], False), ([], False),
    ],
)  # fmt: skip
def test_registers_without_a_mark(words: list[str], is_hexadecimal: bool) -> None:
    assert bare_hexadecimal(words) is is_hexadecimal


def test_registers_are_read_as_counts(tmp_path: Path) -> None:
    log = tmp_path / "a.csv"
    log.write_text("channel,load_n,counts\nfl,0,7FFE3A\nfl,1,7FFF00\n")
    counts = read_table(log, weights_table(), {}, gravity_mps2=G).number("counts")
    assert counts.tolist() == [0x7FFE3A, 0x7FFF00]


@pytest.mark.parametrize("blank", [" ", "\u00a0", "\u202f"])
def test_blanks_of_any_width_between_thousands(tmp_path: Path, blank: str) -> None:
    log = tmp_path / "a.csv"
    log.write_text(f"a;b\n1{blank}000,5;8{blank}388{blank}607\n0,5;-97{blank}828\n", "utf-8")
    layout = Layout(separator=";", decimal=",", thousands=blank)
    frame, lines = text_table(log, layout, ())
    assert frame["a"].tolist() == [1000.5, 0.5]
    assert frame["b"].tolist() == [8_388_607, -97_828]
    assert lines.tolist() == [2, 3]


def test_zero_bytes_of_a_logger_without_power() -> None:
    assert before_power_was_lost(b"a,b\n1,2\n3,4" + bytes(64)) == b"a,b\n1,2\n"
    assert before_power_was_lost(b"a,b\n1,2\n") == b"a,b\n1,2\n"
    assert before_power_was_lost(b"a\0b\n1,2" + bytes(64)).count(b"\0") == 65  # no text at all


def test_what_was_put_on_holds_until_the_next_event(tmp_path: Path) -> None:
    log = tmp_path / "a.csv"
    log.write_text("t_s,raw,event\n0,5,\n1,1,load 2 kg\n2,1,\n3,3,load 4 kg\n4,3,\n")
    said = recipe(
        tmp_path,
        """
        [columns]
        time_s = "t_s"
        cell_counts = "raw"
        load_n = { column = "event", unit = "kg", held = true, pattern = '(\\d+) kg' }
    """,
    )
    table = read_table(log, weights_stream_table(("cell",)), said.reading(log), gravity_mps2=G)
    np.testing.assert_allclose(table.number("load_n") / G, [np.nan, 2, 2, 4, 4])


def test_a_weight_on_one_cell_at_a_time(tmp_path: Path) -> None:
    log = tmp_path / "a.csv"
    log.write_text("on,kg,N,S\nN,2,10,1\nS,3,4,9\n")
    text = """
        [[files]]
        [files.wide.N]
        counts = "N"
        load_n = { column = "kg", unit = "kg", only_where = { on = "N" } }
        [files.wide.S]
        counts = "S"
        load_n = { column = "kg", unit = "kg", only_where = { on = "S" } }
    """
    table = read_table(log, weights_table(), recipe(tmp_path, text).reading(log), gravity_mps2=G)
    assert list(table.text("channel")) == ["N", "N", "S", "S"]
    np.testing.assert_allclose(table.number("load_n") / G, [2, 0, 0, 3])
    assert table.number("counts").tolist() == [10, 4, 1, 9]
    wrong = recipe(tmp_path, text.replace("{ on =", "{ onto ="))
    with pytest.raises(DataError, match="'onto' that only_where names"):
        read_table(log, weights_table(), wrong.reading(log), gravity_mps2=G)
    added = text.replace('only_where = { on = "N" }', 'plus = { pan_kg = "kg" }')
    with pytest.raises(DataError, match="'pan_kg' that plus names"):
        read_table(log, weights_table(), recipe(tmp_path, added).reading(log), gravity_mps2=G)
    with pytest.raises(UsageError, match="only_where and missing are for a column"):
        recipe(tmp_path, '[columns]\nload_n = { value = 1.0, only_where = { on = "N" } }')


def test_a_pan_that_hangs_under_all_weights_comes_on_top(tmp_path: Path) -> None:
    log = tmp_path / "a.csv"
    log.write_text("cell,lb,counts\na,0,1\na,10,2\n")
    text = """
        [columns]
        channel = "cell"
        load_n = { column = "lb", unit = "lb", add = 1.5 }
    """
    table = read_table(log, weights_table(), recipe(tmp_path, text).reading(log), gravity_mps2=G)
    np.testing.assert_allclose(table.number("load_n"), np.array([1.5, 11.5]) * 0.45359237 * G)


def test_folders_tell_logs_apart_that_are_named_alike(tmp_path: Path) -> None:
    logs = []
    for grams in (0, 500):
        (tmp_path / f"{grams}g").mkdir()
        logs.append(tmp_path / f"{grams}g" / "log.csv")
        logs[-1].write_text("raw\n7\n")
    said = recipe(
        tmp_path,
        """
        [[files]]
        match = "0g/log.csv"
        columns = { counts = { column = "raw", factor = 2.0 } }
        [columns]
        channel = { value = "cell" }
        counts = "raw"
        load_n = { file_name = '^(\\d+)g/', unit = "g" }
    """,
    )
    found = [read_table(x, weights_table(), said.reading(x), gravity_mps2=G) for x in logs]
    assert [table.number("load_n")[0] for table in found] == [0.0, 0.5 * G]
    assert [table.number("counts")[0] for table in found] == [14, 7]
    assert called_as(logs[1], "*.csv") == "log.csv"


def test_names_and_rows_of_a_text_without_fields(tmp_path: Path) -> None:
    log = tmp_path / "a.txt"
    log.write_text("12:00:00 -> load 1 kg\n12:00:01 -> 7\t8\n12:00:02 -> 9\t1\nbye\n")
    layout = Layout(
        line=r"^(?P<time>\S+) -> (?P<a>\d+)\s(?P<b>\d+)$", carried=r"load (?P<load>\d+) kg"
    )
    assert text_names(log, layout) == ["load", "time", "a", "b"]
    frame, lines = text_table(log, layout, ())
    assert frame["a"].tolist() == [7, 9]
    assert frame["load"].tolist() == [1, 1]
    assert lines.tolist() == [2, 3]
    with pytest.raises(DataError, match="no line is a row"):
        text_table(log, Layout(line=r"(?P<a>x{3})"), ())


def test_a_row_with_more_fields_than_names_is_named_with_its_line(tmp_path: Path) -> None:
    log = tmp_path / "a.txt"
    log.write_text("a b\n1 2\n3 4 5\n")
    with pytest.raises(DataError, match="3 fields under a header of 2") as refused:
        text_table(log, Layout(separator=BLANKS), ())
    assert refused.value.row == "line 3"


def test_folders_and_files_that_are_not_there_are_refused(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="is a folder"):
        regular_file(tmp_path)
    with pytest.raises(UsageError, match="no such file"):
        regular_file(tmp_path / "a.csv")
    (tmp_path / "a.csv").write_bytes(b"12345")
    with pytest.raises((DataError, UsageError)):
        regular_file(tmp_path / "a.csv", at_most=4)
    regular_file(tmp_path / "a.csv", at_most=5)


def test_a_place_in_the_file_or_in_the_recipe() -> None:
    assert ForeignColumn("a").in_file
    assert not ForeignColumn(value=1.0).in_file


def test_structs_and_lists_of_parquet(tmp_path: Path) -> None:
    table = pa.table({
        "wrench": pa.array([{"f": {"x": 1.0}}, {"f": {"x": 2.0}}]),
        "q": pa.array([[0.0, 1.0], [1.0, 0.0]]),
    })  # fmt: skip
    pq.write_table(table, tmp_path / "a.parquet")
    found = unpacked(tmp_path / "a.parquet")
    assert list(found) == ["wrench.f.x", "q_0", "q_1"]
    assert found["wrench.f.x"].values.tolist() == [1.0, 2.0]
    pq.write_table(pa.table({"q": pa.array([[0.0], [1.0, 0.0]])}), tmp_path / "b.parquet")
    with pytest.raises(DataError, match="a list of now 1, now 2"):
        unpacked(tmp_path / "b.parquet")


def test_lists_of_parquet_are_columns_of_a_table(tmp_path: Path) -> None:
    table = pa.table({"t": [0.0, 1.0], "q": pa.array([[5.0, 6.0], [7.0, None]])})
    pq.write_table(table, tmp_path / "a.parquet")
    assert column_names(tmp_path / "a.parquet") == ["t", "q_0", "q_1"]
    whole = raw_columns(tmp_path / "a.parquet", ["q_1", "t"], ())
    assert list(whole) == ["q_1", "t"]
    assert whole["q_1"].empty.tolist() == [False, True]
    (piece,) = raw_pieces(tmp_path / "a.parquet", ["q_0"], ())
    assert piece["q_0"].values.tolist() == [5.0, 7.0]


def test_messages_printed_as_text() -> None:
    assert is_of_documents("a:\n  b: 1\n---\na:\n  b: 2\n---\n")
    assert not is_of_documents("a,b\n1,2\n3,4\n")


def test_names_of_the_contract() -> None:
    assert is_canonical("left_fl_counts", ("left_fl",))
    assert is_canonical("known_tx_nm", ())
    assert not is_canonical("left_fl_n", ())
    assert not is_canonical("lod_n", ("left_fl",))


def test_a_column_under_two_names_and_one_in_another_unit(tmp_path: Path) -> None:
    log = tmp_path / "a.csv"
    log.write_text("channel,load_kg,load_n,counts\nfl,1,9,5\n")
    with pytest.raises(DataError, match="stands there more than once"):
        places_of(weights_table(), Reading(), log)
    log.write_text("channel,load_g,counts\nfl,1000,5\n")
    (places,) = places_of(weights_table(), Reading(), log)
    assert places.found["load_n"] == ForeignColumn("load_g", "g")


def test_a_row_for_each_foot_becomes_a_row_per_sample(tmp_path: Path) -> None:
    """Equal stamps, interleaved ones and none; a lost sample is empty, and not bridged."""
    said = 'pivot = {{ by = ["foot"], labels = ["left", "right"]{} }}'
    columns = """
        [columns]
        time_s = {{ column = "{}", unit = "ms" }}
        left_a_counts = "left.raw"
        right_a_counts = "right.raw"
    """
    log = tmp_path / "feet.csv"

    def read(lines: list[str], at: str) -> Table:
        log.write_text("ms,foot,raw\n" + "\n".join(lines) + "\n")
        text = "[[files]]\n" + said.format(f', at = "{at}"' if at else "")
        own = recipe(tmp_path, text + columns.format(at or "left.ms"))
        return read_table(log, cells_table(["left_a", "right_a"]), own.reading(log), gravity_mps2=G)

    equal = [f"{10 * i},{foot},{100 * i + k}" for i in range(8)
             for k, foot in enumerate(("left", "right"))]  # fmt: skip
    table = read(equal, "ms")
    np.testing.assert_array_equal(table.number("right_a_counts"), 100 * np.arange(8) + 1)
    np.testing.assert_allclose(table.number("time_s"), 0.01 * np.arange(8))
    np.testing.assert_array_equal(read(equal, "").number("right_a_counts"), 100 * np.arange(8) + 1)
    # the right foot is read 5 ms after the left: a straight line between its rows
    later = [f"{10 * i + 5 * k},{foot},{100 * i + 50 * k}" for i in range(8)
             for k, foot in enumerate(("left", "right"))]  # fmt: skip
    table = read(later, "ms")
    np.testing.assert_allclose(table.number("right_a_counts"), 100 * np.arange(8), atol=51)
    np.testing.assert_allclose(table.number("right_a_counts")[1:], 100 * np.arange(1, 8))
    # three samples of the right foot are lost: nothing from 25 to 65 ms
    lost = [line for line in later if line not in {later[7], later[9], later[11]}]
    empty = np.isnan(read(lost, "ms").number("right_a_counts"))
    np.testing.assert_array_equal(np.flatnonzero(empty), [3, 4, 5, 6])
    with pytest.raises(DataError, match="different numbers of rows: left 8, right 5"):
        read(lost, "")


def test_rows_without_a_reading_are_left_out_if_the_recipe_says_so(tmp_path: Path) -> None:
    log = tmp_path / "cell.csv"
    log.write_text("load_n,raw\n0,100\n5,-9999\n10,300\n10,NaN\n15,ERR\n20,500\n")
    columns = """
        [columns]
        channel = {{ value = "a" }}
        counts = {{ column = "raw"{} }}
    """
    silent = recipe(tmp_path, columns.format(', missing = ["-9999", "ERR"]'))
    table = read_table(log, weights_table(), silent.reading(log), gravity_mps2=G)
    np.testing.assert_array_equal(table.number("counts"), [100, 300, 500])
    np.testing.assert_array_equal(table.number("load_n"), [0, 10, 20])
    assert [f.sentence for f in table.findings] == [
        "3 of 6 rows have no value in 'raw' and are left out, as `missing` in [columns] says"
    ]
    with pytest.raises(DataError, match="not a number"):
        read_table(
            log, weights_table(), recipe(tmp_path, columns.format("")).reading(log), gravity_mps2=G
        )


def test_a_unit_that_a_recipe_asks_for_is_refused_by_name(tmp_path: Path) -> None:
    log = tmp_path / "cell.csv"
    log.write_text("put_on,raw\n0,100\n5,200\n")
    said = recipe(tmp_path, """
        [columns]
        channel = { value = "a" }
        load_n = { column = "put_on", unit = "?" }
        counts = "raw"
    """)  # fmt: skip
    with pytest.raises(UsageError, match="nothing says the unit of load_n") as refused:
        read_table(log, weights_table(), said.reading(log), gravity_mps2=G)
    assert refused.value.remedy == 'write it in place of "?" in [columns]: N, kg, g, lb …'


def test_records_in_yaml_and_xml_become_a_table(tmp_path: Path) -> None:
    """Nested keys are dotted, texts stay texts, what stands above entries holds for them."""
    yaml = tmp_path / "log.yaml"
    yaml.write_text(
        "rig: B\nsamples:\n  - cell: FL\n    load: {}\n    force:\n      x: 1.5\n  - cell: 'FR'\n"
        "    force:\n      x: 2\n"
    )
    xml = tmp_path / "log.xml"
    xml.write_text(
        '<t><cell id="a"><s t="0"><f>1</f></s></cell>'
        '<cell id="b"><s t="1"><f>2.5</f></s><s t="2"><f>3</f></s></cell></t>'
    )
    found = [next(iter(open_source(path, "header")[0].chunks())) for path in (yaml, xml)]
    assert found[0]["force.x"].tolist() == [1.5, 2.0]
    assert found[0]["cell"].tolist() == ["FL", "FR"]
    assert {name: column.tolist() for name, column in found[1].items()} == {
        "cell.id": ["a", "b", "b"], "t": [0, 1, 2], "f": [1.0, 2.5, 3.0]
    }  # fmt: skip
    xml.write_text("<t><s a='1'/>")
    with pytest.raises(DataError, match="not valid XML"):
        open_source(xml, "header")


def test_what_was_added_and_removed_is_counted() -> None:
    held = Carried(r"(?:on (?P<added_load>\d+)|off (?P<removed_load>\d+))")
    loads = [float(held.holds["load"] or 0)]
    for line in ("on 5", "1234", "on 2", "off 4"):
        held.takes(line)
        loads.append(float(held.holds["load"] or 0))
    assert loads == [0, 5, 5, 7, 3]
