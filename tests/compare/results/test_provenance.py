"""What results are known by: what the code does, not its words."""

import shutil
from pathlib import Path

import pytest

from compare.reports.matrix import page as matrix_report
from compare.results import provenance
from compare.results.provenance import results_digest
from compare.scenes.load import load_scene
from femic.work.provenance import PACKAGES, code_digest, digest_of
from femic.work.store import Store

CODE = '''"""A module."""

FACTOR = 2.0  # a factor


def f(x: float) -> float:
    """Twice x."""
    return FACTOR * x
'''


def digest(folder, text, *facts, name="one.py"):
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir()
    (folder / name).write_text(text, encoding="utf-8")
    return digest_of([folder], *facts)


@pytest.fixture
def of(tmp_path):
    return lambda text, *facts, **options: digest(tmp_path / "package", text, *facts, **options)


WORDS = {
    "comment": ("  # a factor", "  # another comment"),
    "docstring of the module": ("A module.", "The same module."),
    "docstring of a function": ('    """Twice x."""\n', '    """Two times x, in other words."""\n'),
    "no docstring": ('    """Twice x."""\n', ""),
    "layout": ("FACTOR * x", "(\n        FACTOR * x\n    )"),
}
DEEDS = {
    "constant": ("2.0", "3.0"),
    "operator": ("FACTOR * x", "FACTOR + x"),
    "name": ("def f(", "def g("),
    "order": ("FACTOR * x", "x * FACTOR"),
    "text that is used": ("return FACTOR * x", 'return FACTOR * len("x")'),
}


@pytest.mark.parametrize("change", WORDS.values(), ids=WORDS)
def test_words_do_not_change_it(of, change):
    assert CODE.replace(*change) != CODE
    assert of(CODE.replace(*change)) == of(CODE)


@pytest.mark.parametrize("change", DEEDS.values(), ids=DEEDS)
def test_what_the_code_does_changes_it(of, change):
    assert of(CODE.replace(*change)) != of(CODE)


def test_a_text_that_is_no_docstring_counts(of):
    one, other = (f'def f():\n    """Words."""\n    return "{text}"\n' for text in ("a", "b"))
    assert of(one) != of(other)
    assert of('x = 1\n"a"\n') != of('x = 1\n"b"\n')


def test_names_of_files_and_facts_count(of):
    assert of(CODE, name="other.py") != of(CODE)
    assert of(CODE, {"numpy": "2"}) != of(CODE, {"numpy": "3"})
    assert of(CODE, {"numpy": "2"}) == of(CODE, {"numpy": "2"})


def test_a_further_file_counts(tmp_path):
    alone = digest(tmp_path / "package", CODE)
    (tmp_path / "package" / "inner").mkdir()
    (tmp_path / "package" / "inner" / "two.py").write_text("", encoding="utf-8")
    assert digest_of([tmp_path / "package"]) != alone


@pytest.fixture
def copy(tmp_path, monkeypatch):
    """A copy of `compare` in its place, whose digest is computed anew."""
    for folder in provenance.FOLDERS:
        shutil.copytree(folder, tmp_path / folder.name, ignore=shutil.ignore_patterns("__pycache__"))
    monkeypatch.setattr(provenance, "FOLDERS", [tmp_path / folder.name for folder in provenance.FOLDERS])
    return tmp_path / "compare"


def replace_in(path: Path, old: str, new: str) -> None:
    text = path.read_text(encoding="utf-8")
    assert old in text
    path.write_text(text.replace(old, new, 1), encoding="utf-8")


def test_a_measure_of_compare_changes_results_but_no_models(copy):
    models, before = Store().key("harmonic", 1), results_digest.__wrapped__()
    assert before == results_digest()
    replace_in(copy / "results" / "measure.py", "KNOWN = 10.0", "KNOWN = 3.0")
    assert results_digest.__wrapped__() != before
    assert code_digest.__wrapped__() == code_digest()
    assert Store().key("harmonic", 1) == models


def test_models_know_nothing_of_compare():
    assert "compare" not in PACKAGES
    assert code_digest() != results_digest()
    assert code_digest.__wrapped__() == code_digest()


def test_results_depend_on_the_code_of_models(monkeypatch):
    before = results_digest()
    monkeypatch.setattr(provenance, "code_digest", lambda: "0123456789ab")
    assert results_digest.__wrapped__() != before


def test_results_depend_on_the_library_that_writes_them(monkeypatch):
    before = results_digest()
    monkeypatch.setattr(provenance, "version", lambda _: "0.0")
    assert results_digest.__wrapped__() != before


def test_a_matrix_of_other_code_is_made_again(monkeypatch):
    scene = load_scene("geometry2")
    before = matrix_report.key_of_scene(scene, 1)
    assert matrix_report.key_of_scene(scene, 1) == before
    monkeypatch.setattr(matrix_report, "results_digest", lambda: "0123456789ab")
    assert matrix_report.key_of_scene(scene, 1) != before
