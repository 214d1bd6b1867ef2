"""What linear strains leave out: contacts by CalculiX with large displacements (NLGEOM) against small ones.

Both are solved on the same mesh at the same approach, so that the mesh drops out of their ratio. With large
displacements the material is that of St. Venant and Kirchhoff.
"""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path

from contact import Arcs, Found, Patch, Run, by_calculix

from femic.contact.motions.none import solve_frictionless
from femic.contact.pairs.quantities import numbers, s_range
from femic.reference.run_options import RunOptions

PAIRS: Mapping[str, Arcs] = {  # radii of rail and wheel, the latter on a rolling radius of 500 mm
    "10 and 60 mm": Arcs(10.0, 60.0, 500.0, 0.0),
    "10 and 11 mm": Arcs(10.0, 11.0, 500.0, 0.0),
    "10 and 11 mm, moved by 0.3 mm": Arcs(10.0, 11.0, 500.0, 0.3),
    "10 and 10.3 mm": Arcs(10.0, 10.3, 500.0, 0.0),
}
PRESSURES = (525.0, 1050.0, 2100.0)  # MPa, about, by B-hat: 0.25, 0.5 and 1 % of E
HEADER = [
    "pair",
    "N [N]",
    "p_max / E",
    "nodes",
    "change of p_max",
    "change of N",
    "change of F_y / N",
    "p_max at the same approach",
    "N at the same approach",
    "p_max at the same N",
]


def rows(pairs: Mapping[str, Arcs], cells: float, folder: Path) -> Iterator[list[str]]:
    """Rows of the table, pair by pair and load by load."""
    for name, pair in pairs.items():
        for load in loads(pair):
            approach, patch = start(pair, load)
            how = Run(cells, folder)
            small, large = (
                by_calculix(pair, approach, patch, each) for each in (how, replace(how, large=True))
            )
            yield row(name, pair, small, large)


def row(name: str, pair: Arcs, small: Found, large: Found) -> list[str]:
    """Changes by large displacements, and over the strain p_max / E; the last at the same load.

    There the largest pressure, which grows like the cube root of the load (Hertz), is compared at one load.
    """
    strain = small.p_max / pair.material.E
    p_max, load = large.p_max / small.p_max - 1, large.load / small.load - 1
    shares = [p_max / strain, load / strain, (p_max - load / 3) / strain]
    return [
        name,
        f"{small.load:.0f}",
        f"{strain:.2%}",
        small.size.split()[0],
        f"{p_max:+.2%}",
        f"{load:+.2%}",
        f"{large.lateral - small.lateral:+.4f}",
        *(f"{share:+.2f}" for share in shares),
    ]


def start(pair: Arcs, load: float) -> tuple[float, Patch]:
    """Approach [mm] and patch under a load [N] by B-hat: what is near is enough for a ratio."""
    scene = pair.scene({"loads": [load], "ics": ["Bhat"]})
    (contact,) = solve_frictionless(scene.contact_problem, RunOptions(1)).contacts.values()
    known = numbers(contact.on_grid, contact.normal)
    low, high = s_range(contact.on_grid, contact.normal)
    return known["approach"], Patch(known["a"], (float(low), float(high)))


def loads(pair: Arcs) -> Iterator[float]:
    """Loads [N] at which B-hat has about the pressures, by Hertz's law of growth."""
    scene = pair.scene({"loads": [1e3], "ics": ["Bhat"]})
    (contact,) = solve_frictionless(scene.contact_problem, RunOptions(1)).contacts.values()
    p_max = numbers(contact.on_grid, contact.normal)["p_max"]
    for pressure in PRESSURES:
        yield 1e3 * (pressure / p_max) ** 3
