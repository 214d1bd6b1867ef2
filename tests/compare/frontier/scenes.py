"""Contacts for tests of the frontier, with A or B-hat in the place of C: solved in a second."""

import numpy as np
import pytest

from compare.studies import contact_frontier as solving
from femic.contact.operators.approximations import approximate_matrix
from femic.contact.operators.dense import Asymmetry, GridOperator
from femic.contact.pairs.ics import ReferenceICs
from geometries.patches import N

SOLVERS = ("femic.contact.pairs.ics", "compare.studies.contact_frontier")
WITH_FRICTION = ("femic.contact.pairs.pair_with_friction", "compare.studies.contact_frontier")
BODY = """
[{name}]
E = {E}
nu = 0.3
contour = {contour}
"""
ARC = '{{ kind = "arc", radius = {radius}, flank_inclination_deg = 60.0 }}'


def text(top="", contact="loads = [2e4]", motion="", radius=10.5):
    """A scene of a wheel on a rail, with keys at the top, and of its contact."""
    lower = BODY.format(name="lower", E=210e3, contour=ARC.format(radius=10.0))
    upper = BODY.format(name="upper", E=150e3, contour=ARC.format(radius=radius))
    contact = f"[contact]\nelements = 8\nsupports = false\n{motion}\n{contact}"
    return f"{top}\n{lower}\n{upper}\nrolling_radius = 400.0\n{contact}\n"


def flat_text(folder):
    """Two half-spaces of unlike materials, and a bump of 0.3 mm on one of them, on which they touch."""
    x, s = np.meshgrid(np.linspace(-5.0, 5.0, 41), np.linspace(-5.0, 5.0, 41))
    gap = np.minimum(x**2 / 60 + s**2 / 30 - 0.3, 0.0)
    np.savetxt(folder / "gap.txt", np.column_stack([x.ravel(), s.ravel(), gap.ravel()]))
    plane = '{ kind = "plane" }'
    bodies = [BODY.format(name=name, E=E, contour=plane) for name, E in (("lower", 210e3), ("upper", 90e3))]
    return "\n".join(
        [*bodies, '[contact]\nelements = 8\nsupports = false\nextra_gap = "gap.txt"\nloads = [3e3]\n']
    )


def as_c(variant, share=0.01):
    """Return functions that give a variant as C, with an estimate of a share of it: nn, and all."""

    def normal(of, on_grid, *_):
        ics = approximate_matrix(variant, of.pair, on_grid.grid)[..., N, N]
        operators = (
            GridOperator.from_ics(factor * ics[..., None, None], (N,)) for factor in (1.0, 1 + share)
        )
        return ReferenceICs(*operators, share, Asymmetry(0.0, "nn"), 1.0, 0.0)

    def full(of, on_grid, *_, **__):
        ics = approximate_matrix(variant, of.pair, on_grid.grid)
        operators = (GridOperator.from_ics(factor * ics) for factor in (1.0, 1 + share))
        return ReferenceICs(*operators, share, Asymmetry(0.0, "nn"), 1.0, 0.0)

    return normal, full


def put(monkeypatch: pytest.MonkeyPatch, variant, share=0.01):
    """Put a variant in the place of C, without models and their plans; C counts as a minute's work."""
    before = solving._seconds_before

    def seconds_before(problem, name, *rest):
        return before(problem, name, *rest) | ({"ics": 60.0} if name == "C" else {})

    monkeypatch.setattr(solving, "_seconds_before", seconds_before)
    monkeypatch.setattr("compare.studies.contact_frontier.expected_seconds", lambda *_: 1.0)
    normal, full = as_c(variant, share)
    for module in SOLVERS:
        monkeypatch.setattr(f"{module}.normal_reference_ics", normal)
    for module in WITH_FRICTION:
        monkeypatch.setattr(f"{module}.full_reference_ics", full)
