"""Commands that test the program itself: `validate`, `extremes`."""

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from compare.validation.extremes.cases import PARTS, Part
from compare.validation.extremes.cases import available as extremes_available
from femic.cli.progress import terminal
from femic.cli.work import DEFAULT_WORK, Work, announce, whole_numbers
from femic.lazy import lazy_imports
from geometries.errors import WrongInput

with lazy_imports():  # those of `extremes` need the extra femic[extremes]
    from compare.validation.extremes import page as extremes_page
    from compare.validation.statements import page as statements_page
    from compare.validation.statements import runs

TOLERANCE = 1e-3  # of C, by default
TIGHTEST, LOOSEST = 1e-4, 0.02  # limits of the tolerance of C


def validate(
    *,
    only: Annotated[
        tuple[int, ...] | None,
        Parameter(help="numbers of statements; default: all", consume_multiple=True, converter=whole_numbers),
    ] = None,
    tolerance: Annotated[float, Parameter(help="of C")] = TOLERANCE,
    work: Work = DEFAULT_WORK,
) -> None:
    """Check statements about the ICs and about this program; write a report with computed verdicts."""
    if not TIGHTEST <= tolerance <= LOOSEST:
        raise WrongInput(f"--tolerance {tolerance:g}: {TIGHTEST:g} ... {LOOSEST:g}")
    numbers = statements_page.select_statements(only)
    folder = work.out or Path("out") / "validation"
    console = terminal()
    with work.options(folder, console) as options:
        report = statements_page.validate(numbers, runs.Runs(options, tolerance), folder)
    announce(report, console)


def extremes(
    *,
    of: Annotated[
        tuple[Part, ...],
        Parameter(
            help="parts to test: analytic ICs, C of each engine, contact without and with friction",
            consume_multiple=True,
        ),
    ] = PARTS,
    work: Work = DEFAULT_WORK,
) -> None:
    """Test every part at the limits of its inputs, and beyond; write errors, cost and messages."""
    if not extremes_available():
        raise WrongInput("femic extremes: run .venv/bin/pip install -c constraints.txt -e '.[extremes]'")
    folder = work.out or Path("out") / "extremes"
    console = terminal()
    with work.options(folder, console) as options:
        report = extremes_page.write_extremes(of, options, folder)
    announce(report, console)
