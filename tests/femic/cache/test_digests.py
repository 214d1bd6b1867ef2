"""What results are known by: what the code does, not its words."""

import shutil

import pytest

from femic.cache import digests
from femic.cache.digests import STUDY_FOLDERS, code_digest, folders_digest, results_digest
from femic.cache.store import Store

CODE = '''"""A module."""

FACTOR = 2.0  # a factor


def f(x: float) -> float:
    """Twice x."""
    return FACTOR * x
'''


@pytest.fixture
def of(tmp_path, monkeypatch):
    """The digest of a folder with one file."""
    monkeypatch.setattr(digests, "ROOT", tmp_path)

    def digest(text, *facts, name="one.py"):
        shutil.rmtree(tmp_path / "package", ignore_errors=True)
        (tmp_path / "package").mkdir()
        (tmp_path / "package" / name).write_text(text, encoding="utf-8")
        return folders_digest(["package"], *facts)

    return digest


WORDS = {
    "comment": ("  # a factor", "  # another comment"),
    "docstring of the module": ("A module.", "The same module."),
    "docstring of a function": ('    """Twice x."""\n', '    """Two times x, in other words."""\n'),
    "docstring with backslashes": ('"""Twice x."""', 'r"""Twice x, \\alpha."""'),
    "no docstring": ('    """Twice x."""\n', ""),
    "blank lines": ("\n\n\ndef f", "\n\ndef f"),
    "blanks at the end of a line": ("# a factor", "# a factor  "),
    "docstring with quotes and marks": ('"""Twice x."""', '\'\'\'Twice "x" # and """more""" (\'\'\''),
}
DEEDS = {
    "constant": ("2.0", "3.0"),
    "operator": ("FACTOR * x", "FACTOR + x"),
    "name": ("def f(", "def g("),
    "order": ("FACTOR * x", "x * FACTOR"),
    "text that is used": ("return FACTOR * x", 'return FACTOR * len("x")'),
    "text with the mark of a comment": ("return FACTOR * x", 'return "# x"'),
    "block of text in brackets": ("return FACTOR * x", 'return len(\n    """x"""\n    )'),
}


@pytest.mark.parametrize("change", WORDS.values(), ids=WORDS)
def test_words_do_not_change_it(of, change):
    assert CODE.replace(*change) != CODE
    assert of(CODE.replace(*change)) == of(CODE)


@pytest.mark.parametrize("change", DEEDS.values(), ids=DEEDS)
def test_what_the_code_does_changes_it(of, change):
    assert of(CODE.replace(*change)) != of(CODE)


def test_code_before_the_first_comment_counts(of):
    assert of("FACTOR = 2.0  # a factor\n") != of("FACTOR = 3.0  # a factor\n")


def test_a_text_that_is_no_docstring_counts(of):
    for form in ('"{}"', '\\\n    """{}"""', "f(\n    '{}'\n)", 'f(\n    """{}"""\n)', '"# {}"', "'\\'# {}'"):
        one, other = (f'def f():\n    """Words."""\n    return {form.format(text)}\n' for text in "ab")
        assert of(one) != of(other)


def test_names_of_files_further_files_and_facts_count(of, tmp_path):
    assert of(CODE, name="other.py") != of(CODE)
    assert of(CODE, {"numpy": "2"}) != of(CODE, {"numpy": "3"})
    assert of(CODE, {"numpy": "2"}) == of(CODE, {"numpy": "2"})
    alone = of(CODE)
    (tmp_path / "package" / "inner").mkdir()
    (tmp_path / "package" / "inner" / "two.py").write_text("", encoding="utf-8")
    assert folders_digest(["package"]) != alone


@pytest.fixture
def copy(tmp_path, monkeypatch):
    """A copy of the program, whose digests are computed anew."""
    for name in ("geometries", "approx", "femic", "compare"):
        shutil.copytree(digests.ROOT / name, tmp_path / name, ignore=shutil.ignore_patterns("__pycache__"))
    monkeypatch.setattr(digests, "ROOT", tmp_path)
    return tmp_path


def anew():
    """Digests of models, results and studies."""
    return code_digest.__wrapped__(), results_digest.__wrapped__(), results_digest.__wrapped__(*STUDY_FOLDERS)


CHANGED = {  # by a file: whether models, results and studies are other ones
    "geometries/contours.py": (True, True, True),
    "approx/forms.py": (True, True, True),
    "femic/reference/discount.py": (True, True, True),
    "geometries/profiles/text.py": (False, True, True),  # scenes read profiles; a model has its contours
    "femic/ic_errors/error_measure.py": (False, True, True),
    "femic/contact/normal.py": (False, True, True),
    "femic/scenes/load.py": (False, True, True),
    "femic/cli/main.py": (False, False, False),
    "femic/interface/ics.py": (False, False, False),
    "compare/studies/frontier.py": (False, False, True),
    "compare/validation/statements/wheels.py": (False, False, True),
    "compare/pages/ics.py": (False, False, False),
}


@pytest.mark.parametrize(("file", "expected"), CHANGED.items(), ids=CHANGED)
def test_a_change_of_a_file_counts_for_what_depends_on_it(copy, file, expected):
    models, before = Store().key("harmonic", 1), anew()
    assert before == (code_digest(), results_digest(), results_digest(*STUDY_FOLDERS))
    with (copy / file).open("a", encoding="utf-8") as opened:
        opened.write("\nMORE = 1\n")
    assert tuple(old != new for old, new in zip(before, anew(), strict=True)) == expected
    assert Store().key("harmonic", 1) == models  # of this process


def test_results_depend_on_the_library_that_writes_them(monkeypatch):
    before = results_digest()
    monkeypatch.setattr(digests, "version", lambda _: "0.0")
    assert results_digest.__wrapped__() != before
