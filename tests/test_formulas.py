"""Formulas for conforming contact: what the page runs, beside contacts of femic; how they were fitted."""

import json
import re
from pathlib import Path

import contact_formulas as tool
import numpy as np
import pytest

import femic
from femic.contact.exact.hertz import PointContact, combined_modulus

ROOT = Path(__file__).parents[1]
STEEL = femic.Material(E=210e3, nu=0.3)
MODULUS = combined_modulus(STEEL, STEEL)


@pytest.fixture(scope="module")
def stored():
    return json.loads((ROOT / "docs/numbers/formulas.json").read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def conforming():
    """The function on the page."""
    page = (ROOT / "docs/decide/formulas.md").read_text(encoding="utf-8")
    names = {}
    exec(re.search(r"```python\n(.*?)```", page, re.DOTALL)[1], names)
    return names["conforming"]


@pytest.mark.parametrize(
    ("ratio", "radius", "load"), [(1.02, 300.0, 30e3), (1.1, 60.0, 40e3), (1.01, 2000.0, 60e3)]
)
def test_the_page_predicts_contacts_with_bhat_to_two_percent(conforming, ratio, radius, load):
    """B-hat is within 1 % of C on such arcs, and was not fitted."""
    pair = femic.Pair(
        femic.Body(femic.arc(10.0 * ratio, 70.0), STEEL, rolling_radius=radius),
        femic.Body(femic.arc(10.0, 70.0), STEEL),
    )
    setup = femic.ContactSetup(gap="exact", elements=16)
    found = femic.solve_contact(pair, femic.Frictionless([load]), ["Bhat"], setup).squeeze()
    said = conforming(load, 10.0, 10.0 * ratio, radius, MODULUS)
    assert 35 < float(found.angle) < 85
    assert said["p_max"] == pytest.approx(float(found.p_max), rel=0.02)
    for name in ("approach", "a", "b"):
        assert said[name] == pytest.approx(float(found[name]), rel=0.035), name
    hertz = PointContact(1 / radius, (1 - 1 / ratio) / 10.0, MODULUS).at_load(load)
    assert abs(hertz.p_max / float(found.p_max) - 1) > 0.01


def test_small_loads_are_hertz(conforming):
    for ratio, radius in ((1.01, 20.0), (1.3, 500.0)):
        hertz = PointContact(1 / radius, (1 - 1 / ratio) / 10.0, MODULUS).at_load(0.1)
        said = conforming(0.1, 10.0, 10.0 * ratio, radius, MODULUS)
        for name, value in said.items():
            assert value == pytest.approx(getattr(hertz, name), rel=2e-3), name


def test_coefficients_follow_from_contacts_and_others_judge_them(stored):
    assert tool.fit(stored["contacts"]) == stored["numbers"]
    fitted, judged = (stored["contacts"][name] for name in ("fitted", "judged"))
    assert len(fitted) + len(judged) >= 500
    assert not {row["ratio"] for row in fitted} & {row["ratio"] for row in judged}
    errors = stored["numbers"]["p_max"]["errors"]
    assert errors["formula"]["within"] < 0.02 < errors["hertz"]["within"] < errors["A"]["within"]


def test_cases_have_the_aspect_that_they_say():
    for case in (tool.Case(1.01, 0.4), tool.Case(1.3, 5.0)):
        point = PointContact(1 / case.rolling_radius, case.curvature_s, MODULUS).at_load(100.0)
        assert point.a / point.b == pytest.approx(case.aspect, rel=1e-9)


def test_terms_that_are_there_are_found_again():
    random = np.random.default_rng(1)
    rows = [
        {
            "ratio": random.uniform(1.01, 1.5),
            "aspect": random.uniform(0.3, 5),
            "theta": random.uniform(0.1, 0.7),
        }
        for _ in range(60)
    ]
    true = np.array([0.3, -1.5, 0.1, 2.5, -0.3, -1.25, -0.08, 0.13])
    ratios = np.exp(tool.matrix(tool.columns(rows)) @ true)
    for row, ratio in zip(rows, ratios, strict=True):
        for name in tool.QUANTITIES:
            row |= {name: float(ratio), f"A_{name}": 1.0, f"estimate_{name}": 0.0}
    found = tool.fit({"fitted": rows, "judged": rows})
    for name in tool.QUANTITIES:
        assert found[name]["coefficients"] == pytest.approx(true, rel=1e-6)
        assert found[name]["errors"]["formula"]["within"] < 1e-6
