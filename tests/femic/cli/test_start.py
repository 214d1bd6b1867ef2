"""Commands that end with a message load no heavy library, and what they load later is there."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

import femic
from femic.cli.main import COMMANDS, WRONG_INPUT
from femic.lazy import lazy_imports

HEAVY = {"dask", "distributed", "gmsh", "matplotlib", "pandas", "pyamg", "pyvista", "skfem", "xarray", "zarr"}
OF_SCENES = sorted(set(COMMANDS) - {"validate", "extremes", "scenes", "sweep"})
RUN = """
import json, sys
from femic.cli.main import exit_code
for command in json.loads(sys.argv[1]):
    code = exit_code(command)
    print(json.dumps([code, sorted(sys.modules)]))
"""
WRONG = {
    "not there": None,
    "no TOML": "[lower",
    "an unknown key": "[lower]\nmodulus = 1.0\n",
    "parts that do not fit": Path(femic.__file__).parent.joinpath("scenes/builtin/flat.toml").read_text()
    + "\n[grid]\nds = 1000.0\n",
}


def assert_light(*commands):
    """Each command refuses its input, and the one process in which they run loads no heavy library."""
    done = subprocess.run(
        [sys.executable, "-c", RUN, json.dumps(commands)], capture_output=True, text=True, check=True
    )
    lines = [json.loads(line) for line in done.stdout.splitlines()]
    assert len(lines) == len(commands)
    for command, (code, modules) in zip(commands, lines, strict=True):
        assert code == WRONG_INPUT, command
        assert not HEAVY.intersection(modules), command


def test_a_command_about_a_wrong_scene_loads_no_heavy_library(tmp_path):
    path = tmp_path / "wrong.toml"
    path.write_text(WRONG["an unknown key"])
    assert_light(*([command, str(path)] for command in OF_SCENES))


def test_wrong_scenes_are_refused_before_heavy_libraries_load(tmp_path):
    paths = [tmp_path / f"{case}.toml" for case in WRONG]
    for path, text in zip(paths, WRONG.values(), strict=True):
        if text is not None:
            path.write_text(text)
    assert_light(*(["run", str(path)] for path in paths))


def test_wrong_campaigns_are_refused_before_heavy_libraries_load(tmp_path):
    paths = [tmp_path / f"{name}.toml" for name in ("nowhere", "no_toml")]
    for path, text in zip(paths, ('scene = "nowhere"', "[sweep"), strict=True):
        path.write_text(text)
    assert_light(*(["sweep", str(path)] for path in paths))


def test_a_wrong_tolerance_of_statements_is_refused_before_heavy_libraries_load():
    assert_light(["validate", "--tolerance", "9"])


def test_a_lazy_import_runs_a_module_when_it_is_used(tmp_path, monkeypatch):
    (tmp_path / "lazily.py").write_text("from colorsys import hls_to_rgb\nanswer = 42\n")
    monkeypatch.syspath_prepend(tmp_path)
    finders = list(sys.meta_path)
    with lazy_imports():
        import lazily  # noqa: PLC0415
    assert sys.meta_path == finders
    assert "lazily" not in sys.modules
    assert lazily.answer == 42
    with lazy_imports():
        import lazily as again  # noqa: PLC0415
    assert again is sys.modules["lazily"]
    assert lazily.hls_to_rgb is sys.modules["colorsys"].hls_to_rgb


def test_two_modules_may_defer_the_same_library(tmp_path, monkeypatch):
    """The second import does not run it; once it runs, what it imports itself is there."""
    (tmp_path / "twice").mkdir()
    (tmp_path / "twice/__init__.py").write_text("from twice.parts import answer\n")
    (tmp_path / "twice/parts.py").write_text("answer = 42\n")
    monkeypatch.syspath_prepend(tmp_path)
    with lazy_imports():
        import twice  # noqa: PLC0415
    with lazy_imports():
        import twice as again  # noqa: PLC0415

        assert "twice.parts" not in sys.modules
        assert again.answer == twice.answer == 42


def test_a_lazy_import_of_no_module_is_an_error():
    with pytest.raises(ModuleNotFoundError, match=r"femic\.nowhere"), lazy_imports():
        import femic.nowhere  # noqa: F401, PLC0415
