"""What the rigid-body discount is worth in normal contact: docs/evidence/accuracy.md.

    python benchmarks/contact_discount.py [approach in mm ...] [--record]

Geometry 2, frictionless, at fixed vertical approaches: the load with C after the discount, and by how much
the loads with raw C, A and B-hat differ from it. Solved by `femic.contact`, with the nn part of the ICs.
"""

from tables import Record, arguments, print_table

from femic.reference.run_options import RunOptions
from femic.results.contact import solve_scene
from femic.scenes.load import load_scene

APPROACHES = (0.01, 0.015, 0.02)  # mm
RECORD = Record(
    "contact_discount.loads",
    "The discount in contact",
    "Geometry 2 without friction at a given approach: the load with C after the discount `approach`, and "
    "how much the loads with raw C, A and B̂ differ from it.",
    "python benchmarks/contact_discount.py",
)


def loads(discount: str, ics: list[str], approaches: list[float]) -> dict[tuple[str, float], float]:
    """Return the loads [N] by ICs and approach, with C after a discount."""
    contact = {"approaches": approaches, "ics": ics, "supports": False}
    changes = {"engine": {"check": False}, "discount": discount, "contact": contact}
    contacts = solve_scene(load_scene("geometry2", changes), RunOptions(2)).contacts
    return {(name, loading.approach): solved.normal.load for (loading, name), solved in contacts.items()}


def main(approaches: list[float]) -> None:
    """Print the table."""
    discounted = loads("approach", ["C", "A", "Bhat"], approaches)
    raw = loads("none", ["C"], approaches)
    rows = []
    for approach in approaches:
        load = discounted["C", approach]
        others = raw["C", approach], discounted["A", approach], discounted["Bhat", approach]
        rows.append([f"{approach:g}", f"{load:,.0f}", *(f"{other / load - 1:+.1%}" for other in others)])
    print_table(["approach [mm]", "load with C [N]", "raw C", "A", "B̂"], rows, record=RECORD)


if __name__ == "__main__":
    main([float(word) for word in arguments()] or list(APPROACHES))
