"""Commands that end with a message load no heavy library, and what they load later is there."""

import json
import subprocess
import sys

import pytest

from femic.cli.main import COMMANDS, WRONG_INPUT
from femic.lazy import lazy_imports
from femic.scenes.load import load_scene

HEAVY = {"dask", "distributed", "gmsh", "matplotlib", "pandas", "pyamg", "pyvista", "skfem", "xarray", "zarr"}
OF_SCENES = sorted(set(COMMANDS) - {"validate", "extremes", "scenes", "sweep"})
RUN = """
import json, sys
from femic.cli.main import exit_code
for command in json.loads(sys.argv[1]):
    code = exit_code(command)
    print(json.dumps([code, sorted(sys.modules)]))
"""
WRONG = {  # files by name, and the commands that refuse them
    "unknown_key.toml": ("[lower]\nmodulus = 1.0\n", OF_SCENES),
    "nowhere.toml": (None, ["run", "sweep"]),
    "no_toml.toml": ("[lower", ["run", "sweep"]),
    "misfit.toml": (load_scene("flat").text + "\n[grid]\nds = 1000.0\n", ["run"]),
    "campaign.toml": ('scene = "nowhere"', ["sweep"]),
}


def test_wrong_input_is_refused_before_heavy_libraries_load(tmp_path):
    """All commands in one process, which names the first that loads a library."""
    commands = [["validate", "--tolerance", "9"]]
    for name, (text, refusing) in WRONG.items():
        if text is not None:
            (tmp_path / name).write_text(text, encoding="utf-8")
        commands += [[command, str(tmp_path / name)] for command in refusing]
    call = [sys.executable, "-c", RUN, json.dumps(commands)]
    printed = subprocess.run(call, capture_output=True, text=True, check=True).stdout
    for command, line in zip(commands, printed.splitlines(), strict=True):
        code, modules = json.loads(line)
        assert code == WRONG_INPUT, command
        assert not HEAVY.intersection(modules), command


def test_a_page_of_contact_loads_only_what_it_shows(tmp_path):
    """Its charts are drawn in the browser: Matplotlib draws for paper only. Maps of C are not there."""
    (tmp_path / "one.toml").write_text(
        load_scene("tall").text.replace("[7.4e3, 58e3, 310e3]", "[7.4e3]"), encoding="utf-8"
    )
    command = ["contact", str(tmp_path / "one.toml"), "--ics", "A", "--out", str(tmp_path / "out")]
    call = [sys.executable, "-c", RUN, json.dumps([command])]
    printed = subprocess.run(call, capture_output=True, text=True, check=True, cwd=tmp_path).stdout
    code, modules = json.loads(printed.splitlines()[-1])
    assert code == 0
    assert not {"matplotlib", "pyvista", "zarr"}.intersection(modules)


@pytest.fixture
def module(tmp_path, monkeypatch):
    """Write a module that can be imported."""
    monkeypatch.syspath_prepend(tmp_path)

    def write(name, text):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text, encoding="utf-8")

    return write


def test_a_lazy_import_runs_a_module_when_it_is_used(module):
    module("lazily.py", "from colorsys import hls_to_rgb\nanswer = 42\n")
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


def test_a_module_that_is_imported_lazily_may_itself_import_lazily(module):
    module(
        "outer.py",
        """
from femic.lazy import lazy_imports
with lazy_imports():
    import inner
answer = 42
def ask():
    return inner.answer
""",
    )
    module("inner.py", "answer = 43\n")
    with lazy_imports():
        import outer  # noqa: PLC0415
    assert outer.answer == 42
    assert "inner" not in sys.modules
    assert outer.ask() == 43
    assert sys.modules["inner"].answer == 43


def test_two_modules_may_defer_the_same_library(module):
    """The second import does not run it; once it runs, what it imports itself is there."""
    module("twice/__init__.py", "from twice.parts import answer\n")
    module("twice/parts.py", "answer = 42\n")
    with lazy_imports():
        import twice  # noqa: PLC0415
    with lazy_imports():
        import twice as again  # noqa: PLC0415

        assert "twice.parts" not in sys.modules
        assert again.answer == twice.answer == 42


def test_a_lazy_import_of_no_module_is_an_error():
    with pytest.raises(ModuleNotFoundError, match=r"femic\.nowhere"), lazy_imports():
        import femic.nowhere  # noqa: F401, PLC0415
