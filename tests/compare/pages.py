"""What pages have, as tests read it: charts as browsers get them, tables as texts, and widths."""

import json
from contextlib import contextmanager
from types import MappingProxyType

import numpy as np
import pytest

from compare.report.interactive import SHARED, as_json
from compare.report.tables import MINUS
from tests.pages import widest

AT_800_PX = MappingProxyType({800: 770})


@contextmanager
def without_pictures():
    """Runs draw no sections and meshes: half of their time where models are coarse."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("compare.pages.ics_results.pictures", lambda *_: iter(()))
        yield


def read_chart(chart):
    """A chart as the browser gets it, with the arrays of its traces in their places."""
    return with_arrays(json.loads(as_json(chart)))


def with_arrays(content):
    """What a page has of a chart, with arrays instead of their numbers."""
    for trace in (trace for cells in content["steps"] for cell in cells for trace in cell["traces"]):
        for key in SHARED:
            if isinstance(trace.get(key), int):
                trace[key] = content["arrays"][trace[key]]
        if "kinds" in trace:
            names = [*trace["kinds"], ""]  # the last of what is unknown
            trace["text"] = [[names[-1 if kind is None else kind] for kind in row] for row in trace["z"]]
    return content


def require_map(shown, expected):
    """Values of a map are those expected, to a thousandth of their range or of the largest one."""
    largest = max(float(np.nanmax(np.abs(expected))) / 10, float(np.nanmax(expected) - np.nanmin(expected)))
    np.testing.assert_allclose(shown, expected, rtol=0, atol=1e-3 * largest)


def read_traces(cell):
    """The traces of a cell of a chart by their names."""
    return {trace["name"]: trace for trace in cell["traces"] if trace.get("name")}


def read_texts(table):
    """The texts of the cells of a table by the names of its rows."""
    return {row.name: [cell.text for cell in row.filled] for row in table.rows}


def read_number(text):
    """The number and its estimate of a text such as "−684.3 ± 4.3 % at 1 N"; unresolved ones are 0."""
    shown, _, known = text.partition(" at ")[0].replace(MINUS, "-").removesuffix(" %").partition(" ± ")
    return 0.0 if shown == "within" else float(shown), float(known or 0.0)


def require_number(text, value, estimate):
    """A text such as "−684.3 ± 4.3" has the estimate, and the number to a tenth of it; or both in one."""
    shown, known = read_number(text)
    if text.startswith("within"):
        assert known == pytest.approx(abs(float(value)) + float(estimate), rel=0.05)
        return
    assert known == pytest.approx(float(estimate), rel=0.05)
    assert shown == pytest.approx(float(value), abs=float(estimate) / 10)


def require_room(browser, path, tables=AT_800_PX):
    """No page is wider than its window, and no table wider than given by the width of the window [px]."""
    for width, most in tables.items():
        page, table = widest(browser, path, width)
        assert page <= width
        assert table <= most, width
