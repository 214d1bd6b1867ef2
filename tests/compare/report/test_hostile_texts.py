"""Texts of users on pages: shown as they are, whatever they mean to HTML, JSON, Plotly, Matplotlib or XML."""

import json
from html.parser import HTMLParser
from io import BytesIO
from string import ascii_letters, digits
from xml.etree import ElementTree

import matplotlib as mpl
import numpy as np
import pytest

from compare.report import static
from compare.report.charts import Chart, Curve, Map, Panel
from compare.report.looks import label_looks
from compare.report.parts import Page, Section, write_index, write_page
from compare.report.tables import Cell, Row, Table

X = np.linspace(0.0, 1.0, 3)
BASE64 = set(ascii_letters + digits + "+/=")
HOSTILE = ["<!-- <script> x </script><b>bold</b> &lt;", "_$\\frac{x$ \\$5 %{q} {{ 7 }}"]


class Contents(HTMLParser):
    """Title, headings, cells of tables and scripts of a page, as a browser finds them."""

    def __init__(self, text):
        super().__init__()
        self.found, self.open = {"title": [], "h1": [], "td": [], "script": []}, []
        self.feed(text)
        self.close()

    def handle_starttag(self, tag, attrs):  # noqa: ARG002
        self.open.append(tag)
        if tag in self.found:
            self.found[tag].append("")

    def handle_endtag(self, tag):
        while self.open and self.open.pop() != tag:
            pass

    def handle_data(self, data):
        if self.open and self.open[-1] in self.found:
            self.found[self.open[-1]][-1] += data


def hostile_chart(text):
    """Return a chart with a text wherever a chart has texts."""
    curve = Curve(text, X, X, label_looks([text])[text], names=[text] * 3, notes=[text] * 3)
    panel = Panel(text, text, text, [curve], names_x=[text] * 3)
    kinds = Map(text, text, text, X, X, np.eye(3), text, classes=[text, "other"], names_y=[text] * 3)
    numbers = Map(text, text, text, X, X, np.eye(3), text)
    return Chart("chart", {text: [panel, kinds, numbers], "b": [panel, kinds, numbers]}, slider=text)


def drawn(chart):
    """Return the picture of a chart as XML with texts; raise where it is none."""
    file = BytesIO()
    with mpl.rc_context({"svg.fonttype": "none"}):
        static.picture(chart).savefig(file, format="svg")
    return ElementTree.fromstring(file.getvalue())


def strings(part):
    """Yield all texts in a part of JSON."""
    if isinstance(part, str):
        yield part
    elif isinstance(part, dict | list):
        for inner in part.values() if isinstance(part, dict) else part:
            yield from strings(inner)


@pytest.mark.parametrize("text", HOSTILE)
def test_a_page_has_its_charts_and_shows_each_text_as_it_is(text, tmp_path):
    table = Table("t", ["c"], [Row(text, [Cell(text)])], is_text=True)
    sections = [Section(text, [table, hostile_chart(text)])]
    page = write_page(Page(text, text, sections), tmp_path / "page.html")
    found = Contents(page.read_text(encoding="utf-8")).found
    assert found["title"] == found["h1"] == [text]
    assert found["td"] == [text]
    data, plotly, explore = found["script"]
    assert "<" not in data  # with <!-- and <script in it, a browser does not see its end
    assert set(plotly) <= BASE64
    assert "JSON.parse" in explore
    content = json.loads(data)
    assert content["labels"] == [text, "b"]
    assert content["legend"][0]["label"] == text


@pytest.mark.parametrize("text", HOSTILE)
def test_plotly_gets_no_tag_and_no_template_that_a_user_wrote(text, tmp_path):
    page = write_page(Page("", "", [Section("", [hostile_chart(text)])]), tmp_path / "page.html")
    data = Contents(page.read_text(encoding="utf-8")).found["script"][0]
    for cell in json.loads(data)["steps"][0]:
        for trace in cell["traces"]:
            trace.pop("legendgroup", None)  # is not shown
        for shown in strings([cell["traces"], cell["layout"]]):
            assert "<" not in shown.replace("<extra></extra>", "").replace(
                "<extra>%{fullData.name}</extra>", ""
            )
            assert "%{q}" not in shown


@pytest.mark.parametrize("text", HOSTILE)
def test_pictures_have_each_text_letter_by_letter(text):
    texts = [node.text for node in drawn(hostile_chart(text)).iter() if node.tag.endswith("}text")]
    assert texts.count(text) >= 10


def test_control_characters_leave_pictures_readable():
    texts = [node.text or "" for node in drawn(hostile_chart("bell\x07 and \x00")).iter()]
    assert sum("bell" in text and "and" in text for text in texts) >= 10


def test_pages_are_listed_whatever_their_folders_are_called(tmp_path):
    names = ["a#b", "c%20d", "javascript:alert(1)", "e?f", "g\udcff"]
    for name in names:
        write_page(Page("ICs", "", []), tmp_path / name / "report.html")
    text = write_index(tmp_path).read_text(encoding="utf-8")
    for link in ("a%23b", "c%2520d", "javascript%3Aalert%281%29", "e%3Ff", "g%FF"):
        assert f'href="{link}/report.html"' in text
