"""femic against the reference outputs that CONTACT publishes with its examples: print a table.

    python tools/contact_reference.py FOLDER

FOLDER is `examples` of CONTACT's public repository (github.com/eve70a/CONTACT): the reference outputs of its
authors, *.ref_out and *.ref_subs, and profiles of the Manchester benchmark. Nothing of it is part of femic.
docs/evidence/other-programs.md has the table.
"""

import argparse
import re
import sys
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import tomlkit

from compare.shifts import compute
from femic.contact.exact.cattaneo import ShiftedPoint
from femic.contact.exact.hertz import PointContact, combined_modulus
from femic.contact.pairs.frictionless import solve_frictionless
from femic.contact.pairs.quantities import numbers
from femic.reference.run_options import RunOptions
from femic.scenes.load import load_scene
from femic.shifts.specification import specification_of
from femic.stresses.half_space import half_space_field
from femic.stresses.points import InnerPoints
from femic.stresses.tractions import SurfaceTractions
from geometries.bodies import Body, Domain
from geometries.contours import plane
from geometries.grids import Grid
from geometries.materials import Material

STEEL = Material(2 * 1.28 * 82000.0, 0.28)
Row = tuple[str, str, float, float]  # case, quantity, theirs, ours
# columns of a table of stresses below the surface
FIELDS = ("UX", "UY", "UZ", "SIGHYD", "SIGVM", "SIGXX", "SIGXY", "SIGXZ", "SIGYY", "SIGYZ", "SIGZZ")


def printed(folder: Path, name: str) -> list[dict[str, float]]:
    """The numbers of the cases of a reference output: those of its lines of headings and values."""
    cases = (folder / f"{name}.ref_out").read_text().split("\n Case ")[1:]
    return [dict(_pairs(case)) for case in cases]


def _pairs(case: str) -> Iterator[tuple[str, float]]:
    """Headings and values of a case."""
    lines = case.splitlines()
    for head, values in pairwise(lines):
        if re.match(r" +FN(/G)? +[A-Z]", head):
            yield from zip(head.replace("SHIFT ", "SHIFT_").split(), map(float, values.split()), strict=True)


def conformal(folder: Path) -> Iterator[Row]:
    """A wheel's groove of 10.2 mm on a rail of 10 mm at 45 degrees, turned upright; at an approach."""
    quadratic, true, numerical, *_ = printed(folder, "conformal")
    approach, radius = 0.09089, 460.0 * np.sqrt(2)
    hertz = PointContact(2 * 0.00076859, 2 * 0.00098039, combined_modulus(STEEL, STEEL)).at_approach(approach)
    case = "conforming, 1: quadratic distance"
    yield case, "N, N (Hertz)", quadratic["FN"], hertz.load
    yield case, "p_max, MPa (Hertz)", quadratic["PMAX"], hertz.p_max
    by_ics = at_approach(approach, radius)
    for case, theirs, ics in (("2: true distance", true, "A"), ("3: numerical ICs", numerical, "C")):
        yield f"conforming, {case}", f"N, N ({ics})", theirs["FN"], by_ics[ics]["load"]
        yield f"conforming, {case}", f"p_max, MPa ({ics})", theirs["PMAX"], by_ics[ics]["p_max"]


def at_approach(approach: float, rolling_radius: float) -> dict[str, dict[str, float]]:
    """Numbers of the contact of these arcs by A and by C."""

    def body(radius: float) -> dict[str, Any]:
        contour = {"kind": "arc", "radius": radius, "flank_inclination_deg": 60.0}
        return {"E": STEEL.E, "nu": STEEL.nu, "contour": contour}

    changes = {
        "lower": body(10.0),
        "upper": body(10.2) | {"rolling_radius": rolling_radius},
        "contact": {"approaches": [approach], "ics": ["A", "C"], "elements": 20},
        "engine": {"check": False},
    }
    solved = solve_frictionless(load_scene("geometry2", changes).contact_problem, RunOptions(1))
    return {ics: numbers(contact.on_grid, contact.normal) for (_, ics), contact in solved.contacts.items()}


def cattaneo(folder: Path) -> Iterator[Row]:
    """A ball of 50 mm on a plane, then shifted: Hertz and Cattaneo; theirs on 15 elements across."""
    pressed, shifted = printed(folder, "cattaneo")
    material = Material(2 * 1.42 * 200.0, 0.42)
    hertz = PointContact(0.02, 0.02, combined_modulus(material, material)).at_load(9.1954)
    yield "ball on a plane", "p_max, MPa", pressed["PMAX"], hertz.p_max
    yield "ball on a plane", "approach, mm", pressed["APPROACH"], hertz.approach
    by_shift = ShiftedPoint(hertz, 0.42, 0.4, 0.875 * 0.4 * hertz.load, 0)
    yield "ball, shifted", "shift, mm", shifted["SHIFT_X"], by_shift.shift


def below_a_square(folder: Path) -> Iterator[Row]:
    """Displacements and stresses below a square of 1 mm with a pressure of 1 MPa and a shear of 0.999 MPa."""
    table = [
        [float(word) for word in line.split()]
        for line in (folder / "subsurf.ref_subs").read_text().splitlines()
        if not line.startswith("%")
    ]
    theirs = np.array([row for row in table if row[2] > 0 and any(row[3:])])  # others are counts of points
    body = Body(+1, plane(), Material(2.56, 0.28), Domain(1e4, np.inf))
    tractions = SurfaceTractions(Grid(1, 1, 1.0, 1.0, 0.0), np.array([[[0.999, 0.0, 1.0]]]))
    x, y, z = theirs[:, :3].T
    field = half_space_field(body, tractions, InnerPoints(x - 1e-4, y - 2e-4, z), between_centres=False)
    stress = field.stress
    hydrostatic = np.trace(stress, axis1=1, axis2=2) / 3
    deviator = stress - hydrostatic[:, None, None] * np.eye(3)
    mises = np.sqrt(1.5 * np.sum(deviator**2, axis=(1, 2)))
    parts = [stress[:, i, j] for i, j in ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))]
    for name, their, our in zip(
        FIELDS, theirs[:, 3:].T, [*field.u.T, hydrostatic, mises, *parts], strict=True
    ):
        k = int(np.argmax(np.abs(their - our)))
        yield f"below a square, {len(z)} points", f"{name}, where most apart", float(their[k]), float(our[k])


def manchester(folder: Path) -> Iterator[Row]:
    """The Manchester benchmark without shift and yaw: S1002 on UIC60, 10 kN a wheel, rail inclination 0."""
    theirs, *_ = printed(folder, "mbench_a22_right")
    steel = {"E": STEEL.E, "nu": STEEL.nu}
    tables: dict[str, Any] = {
        "shifts": [0.0],
        "rail": {"profile": str((folder / "MBench_UIC60_v3.prr").absolute())} | steel,
        "wheel": {"profile": str((folder / "MBench_S1002_v3.prw").absolute()), "flange_back": -70.0} | steel,
        "track": {"gauge": 1435.0, "gauge_depth": 14.0, "rail_inclination": 0.0},
        "wheelset": {"flange_back_distance": 1360.0, "nominal_radius": 460.0},
        "contact": {"elements": 40, "load": 10000.0, "ics": ["A"], "planar": False},
    }
    specification = specification_of(tables, Path("manchester.toml"))
    found = compute.compute_shifts(specification, tomlkit.dumps(tables), RunOptions(1)).squeeze()
    right = found.sel(side="right")
    yield "Manchester, 0 mm", "p_max, MPa (A)", theirs["PMAX"], float(right.p_max)
    yield "Manchester, 0 mm", "approach, mm (A)", theirs["APPROACH"], float(right.approach)


CASES = (below_a_square, cattaneo, manchester, conformal)


def main() -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folder", type=Path, help="the folder `examples` of CONTACT")
    folder = parser.parse_args().folder
    sys.stdout.write("| case | quantity | CONTACT | femic | difference |\n|---|---|---|---|---|\n")
    for rows in CASES:
        for case, quantity, theirs, ours in rows(folder):
            share = f"{ours / theirs - 1:+.2%}" if theirs else "-"
            sys.stdout.write(f"| {case} | {quantity} | {theirs:.5g} | {ours:.5g} | {share} |\n")
            sys.stdout.flush()
    return 0


if __name__ == "__main__":
    sys.exit(main())
