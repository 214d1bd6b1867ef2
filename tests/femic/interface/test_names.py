"""The public names: they exist, say what they are, load when used, and the page shows them."""

import inspect
import subprocess
import sys
from pathlib import Path

import pytest

import femic

HEAVY = (
    *("numpy", "scipy", "skfem", "gmsh", "pyamg", "matplotlib", "pyvista", "dask", "distributed", "xarray"),
    "pydantic",
)
PAGE = (Path(__file__).parents[3] / "docs/how-to/python.md").read_text(encoding="utf-8")
NO_UNITS = {  # of which no quantity is an argument or a result
    *("plane", "Pair", "load_pair", "fit_bhat_prime", "compare_ics", "write_for_contact", "plot_ics"),
    *("load_scene", "run_scene", "WrongInput", "Failure"),
}


def test_there_are_less_than_forty_names():
    assert 25 <= len(femic.__all__) < 40
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
