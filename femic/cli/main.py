"""The command line `femic`. Exit codes: 0 done, 1 not converged or failed, 2 wrong input, 130 interrupted.

Commands are named, not imported: `femic --help` answers without loading the numerical libraries.
"""

import io
import logging
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from signal import SIGINT, pthread_kill
from threading import Timer, main_thread

from cyclopts import App, CycloptsError, Parameter
from rich.logging import RichHandler

from femic.cli.progress import terminal
from femic.lazy import lazy_imports
from geometries.errors import Failure, WrongInput

with lazy_imports():
    from femic.scenes import load

DONE, FAILED, WRONG_INPUT, INTERRUPTED = 0, 1, 2, 130
OWN_NAMES = ("femic", "geometries", "approx", "compare")  # of our packages, as they are imported
DELAY = 0.05  # seconds from Ctrl-C in a destructor or callback until it is delivered: that has ended by then

app = App(
    name="femic",
    help="Influence coefficients of non-planar elastic solids: finite elements (C) against approximations.",
    suppress_keyboard_interrupt=False,
    default_parameter=Parameter(negative_iterable=()),
)
COMMANDS = {  # by name: module and function, and the help text
    "run": ("scenes:run", "Compute and compare the ICs of a scene; write a report."),
    "matrix": ("matrix:matrix", "Compute the IC matrix on a grid: all lags and strips."),
    "contact": (
        "contact:contact",
        "Contact with several ICs, with or without friction: pressures, patches, creep forces.",
    ),
    "stresses": (
        "contact:stresses",
        "Stresses inside both bodies under a contact; wear and fatigue of rolling contacts.",
    ),
    "shifts": (
        "shifts:shifts",
        "Contact of a wheelset on its track at many lateral shifts, with several ICs.",
    ),
    "table": (
        "table:table",
        "Table of creep forces over shift, load and creepages, for vehicle codes and other programs.",
    ),
    "sweep": ("sweep:sweep", "Compute many scenes with varied keys, on all cores or on a Dask cluster."),
    "fe-contact": (
        "contact:fe_contact",
        "Contact by finite elements, compared with contact by ICs.",
    ),
    "calibrate": ("matrix:calibrate", "Fit B-hat-prime to C and write the scene with the fit."),
    "export": ("matrix:export", "Write the IC matrix of both bodies for the program CONTACT."),
    "frontier": ("frontier:frontier", "Compare all choices of ICs for a scene: error against time."),
    "advise": ("frontier:advise", "Name the cheapest ICs that meet a tolerance."),
    "validate": ("validate:validate", "Check statements about the ICs and about this program."),
    "extremes": ("validate:extremes", "Test every part at its limits and beyond."),
    "plan": ("plan:plan", "Estimate the cost of a scene before you run it."),
    "compare": ("scenes:compare", "Show the results of two or more scenes in one report."),
    "show": ("scenes:show", "Draw a body under a load: its cells, displacements and stresses."),
    "doctor": ("doctor:doctor", "Check this installation: libraries, names and two known results."),
    "profiles": (
        "profiles:profiles",
        "List the standard profiles, or show how femic reads your profile files.",
    ),
    "scenes": ("scenes:scenes", "List the built-in scenes, or print one with every key."),
}
OPTIONAL = {  # arguments that may be left out, or repeated: cyclopts would call them ARGS
    "contact": "SCENE...",
    "calibrate": "SCENE...",
    "compare": "SCENE...",
    "profiles": "[NAMES...]",
    "shifts": "[SPECIFICATION]",
}
for command, (location, help_text) in COMMANDS.items():
    argument = OPTIONAL.get(command)
    usage = f"Usage: femic {command} [OPTIONS] {argument}" if argument else None
    app.command(f"femic.cli.{location}", name=command, help=help_text, usage=usage)


def main(arguments: list[str] | None = None) -> None:
    """Run the command line and exit the process with its code.

    Letters that the terminal does not have, such as those of B̂ in Latin-1, are printed as question marks.
    """
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")
    sys.exit(exit_code(sys.argv[1:] if arguments is None else arguments))


def exit_code(arguments: list[str]) -> int:
    """Run one command; print the message of an error, and return the exit code."""
    console = terminal(stderr=True, soft_wrap=True)
    logging.basicConfig(
        level=logging.WARNING, format="%(message)s", handlers=[RichHandler(console=console, show_path=False)]
    )
    logging.getLogger("skfem").setLevel(logging.ERROR)
    try:
        for text in (*arguments, str(Path.cwd())):  # pages and datasets, which have these names, are UTF-8
            if any("\ud800" <= letter <= "\udfff" for letter in text):
                raise WrongInput(f"{text!r}: the name is not valid UTF-8; rename the file or folder")
        with delivered_interruptions():
            app(arguments, exit_on_error=False, print_error=False, result_action="return_value")
    except (CycloptsError, WrongInput, Failure, OSError) as error:
        console.print(f"femic: {load.in_keys(error)}")
        return FAILED if isinstance(error, Failure | OSError) else WRONG_INPUT
    except ImportError as error:
        if (error.name or "").partition(".")[0] not in OWN_NAMES:
            raise
        console.print(
            f"femic: {error}. Another package may have overwritten a part of femic; run femic doctor"
        )
        return FAILED
    except KeyboardInterrupt:
        console.print("femic: interrupted. Finished parts are stored; run the same command to continue")
        return INTERRUPTED
    return DONE


@contextmanager
def delivered_interruptions() -> Iterator[None]:
    """Deliver an interruption again that arrived in a destructor or in a callback of a library.

    Python prints its traceback there and goes on, as if nobody had pressed Ctrl-C.
    """
    before = sys.unraisablehook

    def hook(raised: "sys.UnraisableHookArgs") -> None:
        if raised.exc_type is not KeyboardInterrupt:
            before(raised)
            return
        again = Timer(DELAY, pthread_kill, (main_thread().ident, SIGINT))
        again.daemon = True
        again.start()

    sys.unraisablehook = hook
    try:
        yield
    finally:
        sys.unraisablehook = before
