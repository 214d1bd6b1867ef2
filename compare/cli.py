"""The command line `femic`. Exit codes: 0 done, 1 not converged or failed, 2 wrong input, 130 interrupted.

Commands are named, not imported: `femic --help` answers without loading the numerical libraries.
"""

import logging
import sys

from cyclopts import App, CycloptsError
from rich.console import Console
from rich.logging import RichHandler

from geometries.errors import Failure, WrongInput

DONE, FAILED, WRONG_INPUT, INTERRUPTED = 0, 1, 2, 130

app = App(
    name="femic",
    help="Influence coefficients of non-planar elastic solids: finite elements (C) against approximations.",
    suppress_keyboard_interrupt=False,
)
app.command("compare.commands:run", help="Compute and compare the ICs of a scene; write a report.")
app.command("compare.commands:matrix", help="Compute the IC matrix on a grid: all lags and strips.")
app.command("compare.commands:calibrate", help="Fit B-hat-prime to C; write the scene with the fit.")
app.command(
    "compare.commands:calibrate_map",
    name="calibrate-map",
    help="Fits over flank inclination and radius ratio.",
)
app.command("compare.commands:export", help="Write the IC matrix of both bodies for the program CONTACT.")
app.command("compare.commands:frontier", help="Errors against seconds of every way to the ICs of a scene.")
app.command("compare.commands:advise", help="Say which ICs are the cheapest that are good enough.")
app.command("compare.commands:validate", help="Check what is said about these ICs, and this program.")
app.command("compare.commands:extremes", help="Try every part at its limits, and beyond.")
app.command("compare.commands:plan", help="Say what a scene would take, before anything is solved.")
app.command("compare.commands:compare", help="Show the results of two or more scenes in one report.")
app.command("compare.commands:show", help="Draw a body under a load: its cells, displacements and stresses.")
app.command("compare.commands:scenes", help="List the built-in scenes, or print one with every key.")


def main(arguments: list[str] | None = None) -> None:
    """Run the command line and exit with its code."""
    sys.exit(exit_code(sys.argv[1:] if arguments is None else arguments))


def exit_code(arguments: list[str]) -> int:
    """Run one command and translate what went wrong into a message and an exit code."""
    console = Console(stderr=True, soft_wrap=True, highlight=False)
    logging.basicConfig(
        level=logging.WARNING, format="%(message)s", handlers=[RichHandler(console=console, show_path=False)]
    )
    logging.getLogger("skfem").setLevel(logging.ERROR)
    try:
        app(arguments, exit_on_error=False, print_error=False, result_action="return_value")
    except (CycloptsError, WrongInput) as error:
        console.print(f"femic: {error}", markup=False)
        return WRONG_INPUT
    except (Failure, OSError) as error:
        console.print(f"femic: {error}", markup=False)
        return FAILED
    except KeyboardInterrupt:
        console.print("femic: interrupted; what was finished is kept: run the same command to go on")
        return INTERRUPTED
    return DONE
