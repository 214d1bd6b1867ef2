"""Wheelsets over their shifts: seconds, and the equivalent conicities of the reference cases of EN 15302.

python benchmarks/track_geometry.py [seconds] [conicity] [--record]   # default: both; a minute
"""

from time import process_time

import numpy as np
from tables import Record, arguments, print_table

from femic.shifts.sides import lay_out_wheelset
from femic.shifts.specification import builtin_names, load_shifts
from geometries.track.conicity import equivalent_conicity
from geometries.track.en_15302 import CASES, tolerance
from geometries.track.wheelset import RollRule, over_shifts

RULES: tuple[float | RollRule, ...] = (0.0, "about rails")
SHIFTS = np.linspace(-8, 8, 161)


def seconds() -> None:
    """CPU seconds of 161 shifts with their jumps, of the pairs of the package."""
    rows = []
    for name in builtin_names():
        start = process_time()
        layout = lay_out_wheelset(load_shifts(name)[2])
        laid_out = process_time() - start
        start = process_time()
        found = over_shifts(layout, SHIFTS, roll="about rails")
        taken = process_time() - start
        rows.append((name, f"{laid_out:.2f}", len(SHIFTS), len(found.jumps), f"{taken:.2f}"))
    record = Record(
        "track_geometry.seconds",
        "Geometry of wheel and rail",
        "CPU seconds of 161 shifts with their jumps, without contacts.",
        "python benchmarks/track_geometry.py seconds",
    )
    print_table(("pair", "profiles [s]", "shifts", "jumps", "all shifts and jumps [s]"), rows, record=record)


def conicity() -> None:
    """Conicity at 3 mm and the largest deviations from 1 to 7 mm, as shares of the norm's tolerance."""
    rows = []
    for name, case in CASES.items():
        row = [
            name,
            "/".join(case.wheels),
            f"{case.conicity[3.0]:.3f}",
            f"{tolerance(case.conicity[3.0]):.3f}",
        ]
        for rule in RULES:
            differences = case.differences(rule)
            found = {a: equivalent_conicity(*differences, a).value for a in case.conicity}
            apart = {a: abs(found[a] - norm) for a, norm in case.conicity.items() if norm}
            worst = max(apart, key=lambda a: apart[a] / tolerance(case.conicity[a]))
            share = apart[worst] / tolerance(case.conicity[worst])
            row += [f"{found[3.0]:.3f}", f"{share:.2f} at {worst:g} mm"]
        rows.append(row)
    head = ["case", "wheels, left/right", "norm, 3 mm", "its tolerance"]
    for rule in RULES:
        title = "without roll" if rule == 0.0 else "with roll"
        head += [f"{title}, 3 mm", f"{title}, largest deviation over the tolerance"]
    record = Record(
        "track_geometry.conicity",
        "EN 15302: equivalent conicity",
        "The nine reference cases of EN 15302:2021 at amplitudes of 1 to 7 mm. The norm's differences of the "
        "rolling radius are without roll; with roll, shifts are those at the rails.",
        "python benchmarks/track_geometry.py conicity",
    )
    print_table(head, rows, record=record)


if __name__ == "__main__":
    wanted = arguments() or ["seconds", "conicity"]
    for table in (seconds, conicity):
        if table.__name__ in wanted:
            table()
