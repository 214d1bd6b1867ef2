"""Pages as data, and the one file that each becomes: cells, tables, figures, sections, texts."""

import re
from html import unescape

import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure

from compare.report.errors import error_cell
from compare.report.parts import (
    Folded,
    Items,
    Note,
    Page,
    Picture,
    Section,
    Verbatim,
    write_page,
    write_results,
)
from compare.report.tables import Cell, Column, Row, Table, changed_cell, numbers, texts


def html_of(folder, *blocks):
    """The page of a section of blocks."""
    path = write_page(Page("a title", "a summary", [Section("a heading", blocks)]), folder / "page.html")
    return path.read_text(encoding="utf-8")


def rows_of(html):
    """The rows of all tables as texts of cells, tags within cells removed."""
    rows = re.findall(r"<tr.*?</tr>", html, flags=re.DOTALL)
    cells = [re.findall(r"<t[hd][^>]*>(.*?)</t[hd]>", row, flags=re.DOTALL) for row in rows]
    return [[unescape(re.sub(r"<[^>]*>", "", one)) for one in row] for row in cells]


@pytest.mark.parametrize(
    ("one", "text"),
    [
        (Cell(0.12345, ".2%"), "12.35%"),
        (Cell(1234567, ",d"), "1,234,567"),
        (Cell(np.nan, ".3g"), "–"),
        (Cell("vanishes"), "vanishes"),
        (error_cell(np.nan), "–"),
    ],
)
def test_a_cell_is_a_number_in_its_format_or_a_text(one, text):
    assert one.text == text


@pytest.mark.parametrize(("value", "text"), [(3.0, "+1"), (1.5, "−0.5"), (2.0 + 1e-12, "0")])
def test_change_has_a_sign_and_rounding_is_0(value, text):
    one = changed_cell(*map(xr.DataArray, (value, 2.0, 0.01)))
    assert (one.text, one.below) == (text, "of 2.000 ± 0.010")


def test_texts_are_escaped_and_indices_of_ics_are_subscripts(tmp_path):
    table = Table("#", texts("C_nn"), [Row("B̂′_xn", [Cell("A_s of f_φ", link="#s1")])])
    paragraphs = "C_nn & <b>, B̂_sn is B̄_sn", "p_max, M_zz, curves_nn.png, C_seconds, my_name"
    html = html_of(tmp_path, *paragraphs, Verbatim("C_nn <b>"), table)
    for text in (
        "<p>C<sub>nn</sub> &amp; &lt;b&gt;, B̂<sub>sn</sub> is B̄<sub>sn</sub></p>",
        f"<p>{paragraphs[1]}</p>",
        "<pre>C_nn &lt;b&gt;</pre>",  # a scene stays as it is
        ">C<sub>nn</sub></th>",
        ">B̂′<sub>xn</sub></th>",
        '<a href="#s1">A<sub>s</sub> of f<sub>φ</sub></a>',
    ):
        assert text in html


def test_a_table_shows_heads_with_units_and_every_cell(tmp_path):
    columns = [*texts("place"), *numbers("a", unit="mm"), Column("share", "1"), *numbers("n")]
    rows = [Row("first", ["here", Cell(1.5, ".2f", "± 0.1"), "x", "y"]), Row("", ["there", "1", "2", "3"])]
    html = html_of(tmp_path, Table("name", columns, rows))
    assert rows_of(html) == [
        ["name", "place", "a [mm]", "share [-]", "n"],
        ["first", "here", "1.50± 0.1", "x", "y"],
        ["", "there", "1", "2", "3"],
    ]
    assert html.count('<tr class="first">') == 1  # where a group of rows begins
    assert '<td class="text">here</td>' in html
    assert "<td>1.50<br><small>± 0.1</small></td>" in html


def test_a_table_of_texts_has_no_groups_where_all_rows_have_names(tmp_path):
    html = html_of(tmp_path, Table("k", ["v"], [Row("a", ["1"]), Row("b", ["2"])], is_text=True))
    assert 'class="first"' not in html
    assert html.count('<td class="text">') == 2


def test_colours_and_links_of_cells_are_in_the_page(tmp_path):
    rows = [Row("a", [Cell("b", colour="#abcdef"), Cell("c", link="#there")])]
    target = Section("d", [], "#fedcba", "there")
    html = html_of(tmp_path, Table("", ["", ""], rows), target)
    assert '<td style="background: #abcdef">b</td>' in html
    assert '<a href="#there">c</a>' in html
    assert '<h3 id="there"><span class="verdict" style="background: #fedcba">d</span></h3>' in html


def test_blocks_appear_in_their_order(tmp_path):
    blocks = "one", Note("two"), Items(["three", "four"]), Verbatim("five"), Folded("six", ["seven"]), ""
    html = html_of(tmp_path, *blocks, Section("eight", ["nine", Section("ten", [])]))
    numbers_in_order = "one two three four five six seven eight nine ten"
    words = ["a title", "a heading", *numbers_in_order.split()]
    places = [html.index(f">{word}<") for word in words]
    assert places == sorted(places)
    assert "<h2>a heading</h2>" in html
    assert "<h3>eight</h3>" in html
    assert "<h4>ten</h4>" in html
    assert "<p></p>" not in html


def test_figures_are_embedded_and_written_beside_the_page(tmp_path):
    sections = [Section(name, [Picture(name, Figure())]) for name in ("first", "second")]
    path = write_results(Page("t", "s", sections), tmp_path / "new", "mine", xr.Dataset({"a": 1}))
    assert path == tmp_path / "new" / "mine.html"
    assert xr.open_dataset(tmp_path / "new" / "mine.nc").a == 1
    assert {one.name for one in (tmp_path / "new" / "figures").iterdir()} == {
        "mine_first.png",
        "mine_second.png",
    }
    html = path.read_text(encoding="utf-8")
    assert re.findall(r'alt="(\w+)" src="data:image/png;base64,iVBOR', html) == ["first", "second"]


def test_existing_picture_is_embedded(tmp_path):
    drawn = tmp_path / "mesh.png"
    drawn.write_bytes(b"a picture")
    assert 'src="data:image/png;base64,YSBwaWN0dXJl"' in html_of(tmp_path, Picture("mesh", drawn))
    assert not list((tmp_path / "figures").iterdir())
