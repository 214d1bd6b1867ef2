"""Messages of `femic` in the words of a scene file."""

import ast
import re
from pathlib import Path

import pytest

import femic
from femic.scenes.contact import ContactTable, StressTable
from femic.scenes.engine import EngineTable
from femic.scenes.file import SceneFile
from femic.scenes.load import OPTIONS, in_keys

OF_PYTHON = {"expected"}  # arguments that no command has
MAKES_TEXT = "_too_expensive"  # a function of femic.reference.refinement


def named(path):
    """The names in backquotes of the texts that a module raises."""
    nodes = ast.walk(ast.parse(path.read_text(encoding="utf-8")))
    sources = [n for n in nodes if isinstance(n, ast.Raise) or getattr(n, "name", "") == MAKES_TEXT]
    texts = [n.value for source in sources for n in ast.walk(source) if isinstance(n, ast.Constant)]
    return {name for text in texts if isinstance(text, str) for name in re.findall(r"`(\w+)`", text)}


def test_every_name_in_a_message_is_a_key_of_a_scene_or_an_option():
    names = set().union(*(named(path) for path in Path(femic.__file__).parent.rglob("*.py")))
    keys = {
        key for table in (EngineTable, ContactTable, StressTable, SceneFile) for key in table.model_fields
    }
    assert {"tolerance", "most_unknowns", "growth", "rotation_reach"} <= names
    assert names <= {*keys, *OPTIONS, *OF_PYTHON}


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("a larger `tolerance` or `most_unknowns`", "a larger engine.tolerance or engine.most_unknowns"),
        ("shorten lines or `rotation_reach`", "shorten lines or rotation_reach"),
        ("`far_radius`, `half_length`", "engine.far_radius, engine.half_length"),
        ("give a `shift` nearer", "give a contact.shift nearer"),
        ("a smaller `fineness`", "a smaller stresses.fineness"),
        ("less `friction`", "less contact.friction"),
        ("more `workers`", "more --workers"),
        ("larger `cells`", "larger --cells"),
        ("use fewer (`workers` = 1)", "use fewer (--workers 1)"),
        ("nothing is named: run `femic scenes`", "nothing is named: run `femic scenes`"),
    ],
)
def test_names_become_keys_and_options(text, expected):
    assert in_keys(RuntimeError(text)) == expected
