"""The public names: they exist, say what they are, load when used, compute one thread at a time."""

import inspect
import subprocess
import sys
from pathlib import Path
from threading import Thread

import pytest

import femic
from femic.interface.options import LOCK, in_turn

HEAVY = (
    *("numpy", "scipy", "skfem", "gmsh", "pyamg", "matplotlib", "pyvista", "dask", "distributed", "xarray"),
    "pydantic",
)
PAGE = (Path(__file__).parents[3] / "docs/how-to/python.md").read_text(encoding="utf-8")
NO_UNITS = {  # of which no quantity is an argument or a result
    *("plane", "Pair", "load_pair", "fit_bhat_prime", "compare_ics", "write_for_contact", "plot_ics"),
    *("load_scene", "run_scene", "WrongInput", "Failure"),
}


def test_there_are_not_too_many_names():
    assert 25 <= len(femic.__all__) < 45
    assert dir(femic) == sorted(femic.__all__)


@pytest.mark.parametrize("name", femic.__all__)
def test_each_name_exists_with_a_docstring_and_units_and_is_on_the_page(name):
    public = getattr(femic, name)
    assert public.__name__ == name
    text = inspect.getdoc(public)
    assert text.split("\n")[0].endswith(".")
    assert name in NO_UNITS or any(unit in text for unit in ("[mm", "[N", "[MPa", "[degrees")), text
    assert f"femic.{name}" in PAGE


def test_unknown_name_is_refused_with_the_known_ones():
    with pytest.raises(AttributeError, match=r"no public name 'Pear': .*Pair"):
        femic.Pear  # noqa: B018  # reading it is what fails


def test_type_checkers_and_users_get_the_same_names():
    source = inspect.getsource(femic)
    block = source.split("if TYPE_CHECKING:\n", 1)[1].split("\n\n", 1)[0]
    assert sorted(line.rsplit(" ", 1)[1] for line in block.splitlines()) == sorted(femic.__all__)


def test_importing_femic_loads_no_library():
    code = f"import sys, femic; print([name for name in {HEAVY} if name in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


# --- threads of a program: calls that compute wait for each other, as Gmsh needs it --------------------


COMPUTE = ("compute_ics", "compute_matrix", "solve_contact", "fit_bhat_prime", "compute_shifts", "run_scene")
TWO = """
from concurrent.futures import ThreadPoolExecutor
import femic

pair, patch = femic.load_pair("geometry1"), femic.Patch(0.3, 0.2)
options = femic.Options(0.3, far_radius=60.0, workers=1)


def solved(s):
    lines, one = [femic.line_along_x(s, 3.0, 5)], {"bodies": ["lower"], "components": ["nn"]}
    return femic.compute_ics(pair, patch, lines, ["C"], options=options, **one)


with ThreadPoolExecutor(2) as threads:
    _, one = threads.map(solved, (0.0, 0.5))
print(float(abs(one.ic - solved(0.5).ic).max()))
"""


@pytest.mark.parametrize("name", COMPUTE)
def test_each_function_that_computes_holds_the_lock(name):
    """Of the layers of the function, one takes the lock."""
    layers, function = [], getattr(femic, name)
    while function is not None:
        layers.append(function.__code__)
        function = getattr(function, "__wrapped__", None)
    assert in_turn(lambda: None).__code__ in layers


def test_one_thread_at_a_time_computes_and_may_call_again_from_a_report():
    free = []

    def attempt():
        free.append(LOCK.acquire(blocking=False))
        if free[-1]:
            LOCK.release()

    def another_thread_may():
        thread = Thread(target=attempt)
        thread.start()
        thread.join()

    in_turn(in_turn(another_thread_may))()
    another_thread_may()
    assert free == [False, True]


def test_two_threads_compute_c():
    """In a process of its own: without the lock, Gmsh ends it."""
    done = subprocess.run(
        [sys.executable, "-c", TWO], capture_output=True, text=True, check=False, timeout=300
    )
    assert (done.returncode, done.stdout) == (0, "0.0\n"), done.stderr[-500:]
