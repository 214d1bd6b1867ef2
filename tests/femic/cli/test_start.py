"""Commands that end with a message load no heavy library, and what they load later is there."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

import femic
from femic.cli.main import COMMANDS, WRONG_INPUT
from femic.late import Late, lazy_imports

HEAVY = {"dask", "distributed", "gmsh", "matplotlib", "pandas", "pyamg", "pyvista", "skfem", "xarray", "zarr"}
OF_SCENES = sorted(set(COMMANDS) - {"validate", "extremes", "scenes", "sweep"})
RUN = """
import sys
from femic.cli.main import exit_code
code = exit_code(sys.argv[1:])
print(*sys.modules)
sys.exit(code)
"""
WRONG = {
    "not there": None,
    "no TOML": "[lower",
    "an unknown key": "[lower]\nmodulus = 1.0\n",
    "parts that do not fit": Path(femic.__file__).parent.joinpath("scenes/builtin/flat.toml").read_text()
    + "\n[grid]\nds = 1000.0\n",
}


def loaded_by(*arguments):
    """The exit code of a command, and the libraries that it has loaded."""
    done = subprocess.run(
        [sys.executable, "-c", RUN, *arguments], capture_output=True, text=True, check=False
    )
    return done.returncode, set(done.stdout.split())


@pytest.mark.parametrize("command", OF_SCENES)
def test_a_command_about_a_wrong_scene_loads_no_heavy_library(command, tmp_path):
    path = tmp_path / "wrong.toml"
    path.write_text(WRONG["an unknown key"])
    code, modules = loaded_by(command, str(path))
    assert code == WRONG_INPUT
    assert not modules & HEAVY


@pytest.mark.parametrize("case", WRONG)
def test_wrong_scene_is_refused_before_heavy_libraries_load(case, tmp_path):
    path = tmp_path / "wrong.toml"
    if WRONG[case] is not None:
        path.write_text(WRONG[case])
    code, modules = loaded_by("run", str(path))
    assert code == WRONG_INPUT
    assert not modules & HEAVY


@pytest.mark.parametrize("text", ['scene = "nowhere"', "[sweep"])
def test_a_wrong_campaign_is_refused_before_heavy_libraries_load(text, tmp_path):
    path = tmp_path / "wrong.toml"
    path.write_text(text)
    code, modules = loaded_by("sweep", str(path))
    assert code == WRONG_INPUT
    assert not modules & HEAVY


def test_a_wrong_tolerance_of_statements_is_refused_before_heavy_libraries_load():
    code, modules = loaded_by("validate", "--tolerance", "9")
    assert code == WRONG_INPUT
    assert not modules & HEAVY


def test_a_lazy_import_runs_a_module_when_it_is_used(tmp_path, monkeypatch):
    (tmp_path / "lazily").mkdir()
    (tmp_path / "lazily/inner.py").write_text("import lazily.trace\nanswer = 42\n")
    (tmp_path / "lazily/trace.py").write_text("")
    monkeypatch.syspath_prepend(tmp_path)
    finders = list(sys.meta_path)
    with lazy_imports():
        from lazily import inner  # noqa: PLC0415
    assert sys.meta_path == finders
    assert "lazily.trace" not in sys.modules
    assert inner.answer == 42
    assert "lazily.trace" in sys.modules


def test_a_lazy_import_of_no_module_is_an_error():
    with pytest.raises(ModuleNotFoundError, match=r"femic\.nowhere"), lazy_imports():
        import femic.nowhere  # noqa: F401, PLC0415


def test_every_function_that_is_imported_late_is_there():
    sources = [path.read_text(encoding="utf-8") for path in Path(femic.__file__).parent.rglob("*.py")]
    places = {place for text in sources for place in re.findall(r'Late\(\s*"([\w.:]+)"', text)}
    assert len(places) > 10
    for place in places:
        assert Late(place).resolved is not None
