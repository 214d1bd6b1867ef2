"""Judge femic by CalculiX, and print what they find: `make calculix`.

    python tools/calculix [--only CASE ...] [--fine] [--folder out/calculix]

C of one load beside the crown of a rail and of a wheel, raw; a shifted contact, with small and with large
displacements; what large displacements change; stresses under a patch. CalculiX is a package of Debian and
Ubuntu, `apt install calculix-ccx`. Meshes, input and the reading of output are this folder's; the bodies,
contours and supports are femic's. With --record the tables also go to docs/numbers/benchmarks, and
tools/write_docs.py puts them on docs/evidence/other-programs.md.
"""

import argparse
import sys
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from time import perf_counter

import ics
import strain
import stresses
from contact import Arcs, Found, Run, by_c, by_calculix, by_elements
from deck import PROGRAM, installed

sys.path.append(str(Path(__file__).parents[2] / "benchmarks"))
from tables import Record, arguments, print_table

LOAD = 12.8e3  # N
SHIFTED = Arcs(10.0, 11.0, 500.0, 0.3)
Rows = Iterable[Sequence[str]]


def ics_table(fine: bool, folder: Path) -> tuple[Sequence[str], Rows]:
    """C of one load, raw."""

    def rows() -> Rows:
        for loaded in (ics.rail(), ics.wheel()):
            yield from ics.rows(loaded, 0.2 if fine else 0.3, folder)

    return ics.HEADER, rows()


def contact_table(fine: bool, folder: Path) -> tuple[Sequence[str], Rows]:
    """A shifted contact without friction."""

    def rows() -> Rows:
        elements, approach, patch = by_elements(SHIFTED, LOAD, 12.0 if fine else 8.0)

        def row(name: str, found: Found) -> list[str]:
            against = [found.load / elements.load - 1, found.p_max / elements.p_max - 1]
            known = "" if found.estimate is None else f" ± {found.estimate:.0f}"
            numbers = [f"{found.load:.0f}", f"{found.lateral:.4f}", f"{found.p_max:.1f}{known}"]
            shares = ["" if found is elements else f"{share:+.2%}" for share in against]
            return [f"{name}, {found.size}", *numbers, *shares]

        yield row("femic, finite elements", elements)
        yield row("femic, C", by_c(SHIFTED, approach, 20))
        for cells in (4.0, 6.0) if fine else (3.0, 4.0):
            for large, what in ((False, "small"), (True, "large")):
                found = by_calculix(SHIFTED, approach, patch, Run(cells, folder, large))
                yield row(f"CalculiX, {what} displacements", found)

    return [
        "by",
        "N [N]",
        "F_y / N",
        "p_max [MPa]",
        "N over femic's elements",
        "p_max over femic's elements",
    ], rows()


def strain_table(fine: bool, folder: Path) -> tuple[Sequence[str], Rows]:
    """What large displacements change."""
    return strain.HEADER, strain.rows(strain.PAIRS, 4.0 if fine else 2.5, folder)


def stress_table(fine: bool, folder: Path) -> tuple[Sequence[str], Rows]:
    """Stresses under a patch with shear."""
    return stresses.HEADER, stresses.rows(0.2 if fine else 0.3, folder)


CASES: dict[str, Callable[[bool, Path], tuple[Sequence[str], Rows]]] = {
    "ics": ics_table,
    "contact": contact_table,
    "strain": strain_table,
    "stresses": stress_table,
}


SHOWS = {
    "ics": (
        "Raw C beside the crown, 1e-6 mm/N. The rail is the lower body of Geometry 1, the wheel the "
        "upper one of Geometry 2, loaded 3 mm beside the crown and clamped at a far arc of 40 mm. At "
        "nine points up to 6 mm away; of each component the point with the largest difference."
    ),
    "contact": (
        "Arcs of 10 mm (rail) and 11 mm (wheel, R_roll 500 mm), flanks at 60°, steel, far arcs of 30 mm, "
        "the wheel moved aside by 0.3 mm, no friction, at one approach. Cells are those along the half-width."
    ),
    "strain": (
        "Contacts with large displacements against small ones on one mesh: relative changes divided by "
        "p_max / E. Steel, R_roll 500 mm."
    ),
    "stresses": (
        "The rail of the first table under 1000 MPa and a shear of 300 MPa along s on a patch of 2 × 1.6 "
        "mm, at Gauss points 0.25 to 2 mm below it. Differences are divided by the largest stress of all."
    ),
}


def main() -> int:
    """Print the tables; return 2 where CalculiX is not installed."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--only", nargs="+", choices=CASES, default=list(CASES), help="some of the cases")
    parser.add_argument("--fine", action="store_true", help="finer meshes, several times as long")
    parser.add_argument("--folder", type=Path, default=Path("out/calculix"), help="files of CalculiX")
    options = parser.parse_args(arguments())
    if not installed():
        sys.stderr.write(f"{PROGRAM} is not installed: apt install calculix-ccx\n")
        return 2
    for name in options.only:
        start = perf_counter()
        header, rows = CASES[name](options.fine, options.folder / name)
        command = f"python tools/calculix --only {name}{' --fine' if options.fine else ''}"
        title = f"CalculiX: {str(CASES[name].__doc__).rstrip('.')}"
        print_table(header, rows, record=Record(f"calculix.{name}", title, SHOWS[name], command))
        sys.stdout.write(f"\n{perf_counter() - start:.0f} s\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
