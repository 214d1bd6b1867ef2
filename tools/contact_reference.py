"""femic against the reference outputs that CONTACT publishes with its examples: print a table.

    python tools/contact_reference.py FOLDER [--record]

FOLDER is `examples` of CONTACT's public repository (github.com/eve70a/CONTACT): the reference outputs of its
authors, *.ref_out and *.ref_subs, and profiles of the Manchester benchmark. Nothing of it is part of femic.
With --record the table goes to docs/numbers/benchmarks, for docs/evidence/other-programs.md.
"""

import argparse
import re
import sys
from collections.abc import Iterator
from itertools import pairwise, takewhile
from pathlib import Path
from typing import Any

import numpy as np
import tomlkit
import xarray as xr

import femic
from femic.contact.exact.friction import ShiftedPoint
from femic.contact.exact.hertz import PointContact, combined_modulus
from femic.contact.undeformed import Undeformed
from femic.reference.run_options import RunOptions
from femic.results import wheelset as compute
from femic.shifts.specification import parse_specification
from femic.stresses.half_space import half_space_field
from femic.stresses.points import InnerPoints, SurfaceTractions
from geometries.arrays import Array
from geometries.bodies import Body, Domain
from geometries.contours import arc, plane
from geometries.materials import Material
from geometries.patches import Grid
from geometries.surfaces import Surface

sys.path.append(str(Path(__file__).parents[1] / "benchmarks"))
from tables import Record, arguments, print_table

STEEL = Material(2 * 1.28 * 82000.0, 0.28)
APPROACH = 0.09089  # mm, of the conforming example
CONFORMAL = Grid(51, 39, 0.4, 0.4, 0.0)
RADII = (10.0, np.inf), (10.2, 460.0 * np.sqrt(2))  # of arc and rolling circle, of rail and wheel [mm]
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
    hertz = PointContact(2 * 0.00076859, 2 * 0.00098039, combined_modulus(STEEL, STEEL)).at_approach(APPROACH)
    case = "conforming, 1: quadratic distance"
    yield case, "sum of p, N (Hertz)", quadratic["FN"], hertz.load
    yield case, "p_max, MPa (Hertz)", quadratic["PMAX"], hertz.p_max
    found = solved_at_their_distance(overlaps(folder))
    for case, theirs, ics in (("2: exact distance", true, "A"), ("3: numerical ICs", numerical, "C")):
        p = found.p.sel(ics=ics)
        yield f"conforming, {case}", f"sum of p, N ({ics})", theirs["FN"], float(p.sum()) * CONFORMAL.area
        yield f"conforming, {case}", f"p_max, MPa ({ics})", theirs["PMAX"], float(p.max())


def overlaps(folder: Path) -> Array:
    """The distance at the approach [mm] on the grid of the conforming example, (n_s, n_x)."""
    after = (folder / "conformal.inp").read_text().split("% Mx=51, ms=39")[1].splitlines()[1:]
    numbers_of_table = takewhile(lambda line: not line.startswith("%"), after)
    return np.array([float(word) for line in numbers_of_table for word in line.split()]).reshape(39, 51)


def solved_at_their_distance(distance: Array) -> xr.Dataset:
    """The contact by A and C with a given distance: what it differs by from femic's is an extra gap.

    In theirs the curvature along x is the same all over the patch.
    """
    rail, wheel = (femic.Body(femic.arc(r, 60.0), STEEL, rolling_radius=R) for r, R in RADII)
    x = CONFORMAL.dx * (np.arange(CONFORMAL.n_x) - (CONFORMAL.n_x - 1) / 2)
    at = np.meshgrid(x, CONFORMAL.strips)
    flank = np.radians(60.0)
    lower, upper = (
        Surface(side, arc(r, flank, flank), R) for side, (r, R) in zip((-1, +1), RADII, strict=True)
    )
    ours = Undeformed(upper, lower, (-9.0, 9.0)).distance(*at) - APPROACH * np.cos(at[1] / RADII[0][0])
    columns = np.column_stack([values.ravel() for values in (*at, distance - ours)])
    setup = femic.ContactSetup(grid=CONFORMAL, extra_gap=columns)
    motion = femic.Frictionless(approaches=[APPROACH])
    return femic.solve_contact(femic.Pair(wheel, rail), motion, ["A", "C"], setup, femic.Options(workers=1))


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
        yield (
            f"below a square, {len(z)} points",
            f"{name}, largest difference",
            float(their[k]),
            float(our[k]),
        )


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
    specification = parse_specification(tables, Path("manchester.toml"))
    found = compute.compute_shifts(specification, tomlkit.dumps(tables), RunOptions(1)).squeeze()
    right = found.sel(side="right")
    yield "Manchester, 0 mm", "p_max, MPa (A)", theirs["PMAX"], float(right.p_max)
    yield "Manchester, 0 mm", "approach, mm (A)", theirs["APPROACH"], float(right.approach)


RECORD = Record(
    "contact_reference.cases",
    "CONTACT: published reference outputs",
    "The outputs beside the examples of CONTACT (github.com/eve70a/CONTACT, 23 July 2025), and femic. "
    "FOLDER is its folder `examples`.",
    "python tools/contact_reference.py FOLDER",
)
CASES = (below_a_square, cattaneo, manchester, conformal)


def main() -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folder", type=Path, help="the folder `examples` of CONTACT")
    folder = parser.parse_args(arguments()).folder
    print_table(["case", "quantity", "CONTACT", "femic", "difference"], printed_rows(folder), record=RECORD)
    return 0


def printed_rows(folder: Path) -> Iterator[list[str]]:
    for rows in CASES:
        for case, quantity, theirs, ours in rows(folder):
            share = f"{ours / theirs - 1:+.2%}" if theirs else "-"
            yield [case, quantity, f"{theirs:.5g}", f"{ours:.5g}", share]


if __name__ == "__main__":
    sys.exit(main())
