"""Pages as data, and the one file that each becomes: cells, tables, figures, sections; lists of pages."""

import os
import re
from base64 import b64decode
from html import unescape

import numpy as np
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st

from compare.report.errors import error_cell
from compare.report.parts import (
    Folded,
    Items,
    Note,
    Page,
    Picture,
    Section,
    Verbatim,
    join_words,
    onset,
    write_index,
    write_page,
    write_results,
)
from compare.report.tables import (
    Cell,
    Column,
    Row,
    Table,
    changed_cell,
    changes_table,
    number_and_estimate,
    number_text,
    numbers,
    texts,
    with_estimate,
)
from femic.contact.pairs.quantities import OF_FRICTIONLESS


def html_of(folder, *blocks):
    """The page of a section of blocks."""
    path = write_page(Page("a title", "a summary", [Section("a heading", blocks)]), folder / "page.html")
    return path.read_text(encoding="utf-8")


def rows_of(html):
    """The rows of all tables as texts of cells, tags within cells removed."""
    rows = re.findall(r"<tr.*?</tr>", html, flags=re.DOTALL)
    cells = [re.findall(r"<t[hd][^>]*>(.*?)</t[hd]>", row, flags=re.DOTALL) for row in rows]
    return [[unescape(re.sub(r"<[^>]*>", "", one)) for one in row] for row in cells]


def test_a_cell_is_a_number_or_a_text():
    cells = Cell(np.nan, ".3g"), Cell("vanishes"), error_cell(np.nan)
    assert [cell.text for cell in cells] == ["–", "vanishes", "–"]


@pytest.mark.parametrize(("value", "text"), [(3.0, "+1"), (1.5, "−0.5"), (2.0 + 1e-12, "0")])
def test_change_has_a_sign_and_rounding_is_0(value, text):
    one = changed_cell(*map(xr.DataArray, (value, 2.0, 0.01)))
    assert (one.text, one.below) == (text, "before: 2.000 ± 0.010")


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


def test_doubts_stand_between_the_answer_and_the_sections_and_nothing_where_there_are_none(tmp_path):
    answer, sections = Table("the answer", [""], [Row("a", ["b"])]), [Section("a heading", ["text"])]
    pages = [Page("t", "s", sections, answer, doubts) for doubts in (["C_nn is < 0", ""], [""])]
    doubtful, certain = (write_page(page, tmp_path / "page.html").read_text("utf-8") for page in pages)
    places = [doubtful.index(text) for text in ("the answer", "C<sub>nn</sub> is &lt; 0", "a heading")]
    assert places == sorted(places)
    assert doubtful.count("<li>") == 1
    assert 'class="doubts"' not in certain


def test_pictures_are_embedded_and_the_dataset_is_beside_the_page(tmp_path):
    drawn = {name: tmp_path / f"{name}.png" for name in ("first", "second")}
    for name, path in drawn.items():
        path.write_bytes(name.encode())
    sections = [Section(name, [Picture(name, path)]) for name, path in drawn.items()]
    path = write_results(Page("t", "s", sections), tmp_path / "new", "mine", xr.Dataset({"a": 1}))
    assert path == tmp_path / "new" / "mine.html"
    assert xr.open_dataset(tmp_path / "new" / "mine.nc").a == 1
    html = path.read_text(encoding="utf-8")
    embedded = re.findall(r'alt="(\w+)" src="data:image/png;base64,([^"]*)"', html)
    assert [(name, b64decode(content).decode()) for name, content in embedded] == [
        (name, name) for name in drawn
    ]
    assert not (tmp_path / "new" / "figures").exists()


@pytest.mark.parametrize(
    ("value", "estimate", "text"),
    [
        (684.3123, 4.31, "684.3 ± 4.3"),
        (12345.6, 678.0, "12350 ± 680"),
        (-0.0123456, 0.000996, "−0.0123 ± 0.0010"),
        (2.0, 0.0996, "2.00 ± 0.10"),
        (2.9e-8, 19.1, "within ± 19"),  # not resolved
        (-1e-12, 0.25, "within ± 0.25"),
        (0.5, 2.0, "within ± 2.5"),
        (np.nan, 1.0, "–"),
        (520, 640, "500 ± 600"),  # no digits that the estimate does not allow
        (-520, 640, "−500 ± 600"),
        (684.3, 43, "684 ± 43"),
        (40, 640, "within ± 680"),
        (-2e-9, 3e-8, "within ± 3.2e-08"),
        (684.25, 0.0, "684.25"),  # rounding
        (684.25, np.nan, "684.2 ± ?"),  # not known: it must not look like an exact number
        (1.2362e-6, 3.1e-8, "(1.236 ± 0.031)e-6"),
    ],
)
def test_numbers_have_the_digits_that_their_estimate_allows(value, estimate, text):
    assert with_estimate(value, estimate) == text
    assert with_estimate(xr.DataArray(value), xr.DataArray(estimate)) == text


@pytest.mark.parametrize(
    ("value", "estimate", "texts"),
    [
        (2.5, 0.1, ("+2.50", "± 0.10")),
        (-2.5, 0.1, ("−2.50", "± 0.10")),
        (0.5, 0.01, ("+0.500", "± 0.010")),
        (1.2362e-6, 3.1e-8, ("+1.236e-6", "± 0.031e-6")),  # both parts have the power of ten
        (0.2, 10.0, ("within ± 10", "")),
        (3.0, np.nan, ("+3.000", "± ?")),
    ],
)
def test_number_and_estimate_stand_apart_and_differences_have_signs(value, estimate, texts):
    assert number_and_estimate(value, estimate, signed=True) == texts


@given(st.floats(-2, 2), st.floats(1e-3, 1e6))
def test_a_number_is_resolved_from_half_of_its_estimate_on_and_else_within_what_is_shown(share, estimate):
    text = with_estimate(share * estimate, estimate)
    assert text.startswith("within ± ") == (abs(share) <= 0.5) or abs(share) == pytest.approx(0.5, rel=0.06)
    if text.startswith("within ± "):
        assert float(text.removeprefix("within ± ")) == pytest.approx((1 + abs(share)) * estimate, rel=0.051)


def test_other_supports_have_a_column_each_and_changes_far_below_the_estimate_are_0():
    keys = ("p_max", "F_y")
    before = xr.Dataset({"p_max": 1000.0, "estimate_p_max": 10.0, "F_y": 1e-8, "estimate_F_y": 5.0})
    changed = xr.Dataset(
        {"supported_p_max": ("supports", [1010.0, 990.0]), "supported_F_y": ("supports", [3e-8, 4.0])},
        coords={"supports": ["near", "flat"]},
    )
    table = changes_table("t", {key: OF_FRICTIONLESS[key] for key in keys}, before, changed, "supported_")
    assert [head.title for head in table.heads] == ["near", "flat"]
    assert [row.name for row in table.rows] == ["p_max [MPa]", "F_y [N]"]
    assert [[cell.text for cell in row.filled] for row in table.rows] == [["+10", "−10"], ["0", "+4"]]
    assert [row.filled[0].below for row in table.rows] == ["before: 1000 ± 10", "before: within ± 5.0"]


@pytest.mark.parametrize(
    ("value", "form", "text"),
    [
        (-0.0, ".1f", "0.0"),
        (-0.004, "+.0%", "0%"),
        (0.004, "+.0%", "0%"),
        (-0.012, "+.1%", "−1.2%"),
        (0.012, "+.1%", "+1.2%"),
        (-1.5e-7, ".2g", "−1.5e-07"),
        (np.inf, "+.2f", "+inf"),
        (0.0, "+.1e", "0.0e+00"),
        (0.12345, ".2%", "12.35%"),
        (1234567, ",d", "1,234,567"),
    ],
)
def test_numbers_have_minus_signs_and_zero_has_none(value, form, text):
    assert number_text(value, form) == text
    assert Cell(value, form).text == text


ANGLES = [46.2, 80.0, 97.4]


@pytest.mark.parametrize(
    ("beyond", "text"),
    [
        ([False, False, False], ""),
        ([True, True, True], "already at 46 degrees, the smallest angle solved"),
        ([False, True, True], "above a limit between 46 and 80 degrees"),
        ([False, False, True], "above a limit between 80 and 97 degrees"),
        ([False, True, False], "above a limit between 46 and 80 degrees (not at 97)"),
        ([True, False, False], "already at 46 degrees, the smallest angle solved (not at 80 and 97)"),
    ],
)
@pytest.mark.parametrize("order", [[0, 1, 2], [2, 0, 1]])
def test_an_onset_lies_between_the_cases_that_were_solved(beyond, text, order):
    assert onset([ANGLES[k] for k in order], [beyond[k] for k in order]) == text


@pytest.mark.parametrize(("words", "text"), [("", ""), ("a", "a"), ("ab", "a and b"), ("abc", "a, b and c")])
def test_words_are_listed_with_commas_and_and(words, text):
    assert join_words(words) == text


def test_all_pages_are_listed_the_newest_first(tmp_path):
    for age, (name, title) in enumerate({"b": "Contact of <b>", "a": "ICs of a"}.items()):
        path = write_page(Page(title, "", []), tmp_path / name / "report.html")
        os.utime(path, (1e9 - age, 1e9 - age))
    text = write_index(tmp_path).read_text(encoding="utf-8")
    assert text.index('href="b/report.html"') < text.index('href="a/report.html"')
    assert "Contact of &lt;b&gt;" in text
    assert not (tmp_path / "figures").exists()


def test_a_folder_without_pages_has_no_list(tmp_path):
    (tmp_path / "a").mkdir()
    assert write_index(tmp_path) is None
    assert not list(tmp_path.glob("*.html"))


def test_unfinished_and_vanished_pages_are_left_out(tmp_path):
    page = write_page(Page("Contact", "", []), tmp_path / "a" / "contact.html")
    page.with_name(".unfinished.1.report.html").write_text("<title>Half</title>", encoding="utf-8")
    (tmp_path / "a" / "gone.html").symlink_to(tmp_path / "nowhere.html")
    text = write_index(tmp_path).read_text(encoding="utf-8")
    assert 'href="a/contact.html"' in text
    assert "Half" not in text
    assert "gone.html" not in text
