"""Small models of an unsymmetric section: seconds, not accuracy."""

import logging

import numpy as np
import pytest

from femic.solid import Points, Request, assemble, build_mesh
from femic.tetrahedra import Cells
from geometries import contours
from geometries.bodies import LOWER, UPPER, Domain, PrismaticBody
from geometries.materials import Material
from geometries.patches import Patch

logging.getLogger("skfem").setLevel(logging.ERROR)

STEEL = Material(210e3, 0.28)
SMALL = Domain(40.0, 50.0)
COARSE = Cells(0.2, 0.3, 0.2)
UNSYMMETRIC = contours.arc(8.0, np.radians(20), np.radians(35))
SYMMETRIC = contours.arc(10.0, np.radians(25.5), np.radians(25.5))
PATCH = Patch(0.3, 0.5)


def request_for(contour, *, side=LOWER, patch=PATCH, directions=(0, 1, 2), cells=COARSE, **changes):
    body = PrismaticBody(side, contour, changes.get("material", STEEL), changes.get("domain", SMALL))
    x = np.array([1.5, -1.5, 0.0, 4.0, 1.5, -1.5])
    s = np.array([0.8, 0.8, 2.0, -3.0, -0.8, -0.8])
    points = changes.get("points", Points(x, s))
    return Request(body, patch, directions, points, cells, changes.get("solver", "multigrid"))


@pytest.fixture(scope="session", params=[LOWER, UPPER], ids=["lower", "upper"])
def half_model(request):
    return assemble(build_mesh(request_for(UNSYMMETRIC, side=request.param)))
