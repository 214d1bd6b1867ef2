"""What results are known by: what the code does, not its words."""

import shutil
from pathlib import Path

import pytest

from femic.cache import digests
from femic.cache.digests import OF_MODELS, code_digest, digest_of, results_digest
from femic.cache.store import Store

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


ERRORS, FE_CONTACT = "femic.results.ics_dataset", "femic.results.finite_elements"


@pytest.fixture
def copy(tmp_path, monkeypatch):
    """A copy of what results depend on in its place, whose digests are computed anew."""
    for name in {path.split("/")[0] for path in (*digests.PACKAGES, *OF_MODELS)}:
        shutil.copytree(digests.ROOT / name, tmp_path / name, ignore=shutil.ignore_patterns("__pycache__"))
    monkeypatch.setattr(digests, "ROOT", tmp_path)
    return tmp_path


def anew(*modules):
    return results_digest.__wrapped__(*modules)


def append_to(path: Path) -> None:
    assert path.is_file()
    with path.open("a", encoding="utf-8") as file:
        file.write("\nMORE = 1\n")


def test_a_measure_of_errors_changes_results_but_no_models(copy):
    models, before = Store().key("harmonic", 1), anew(ERRORS)
    assert before == results_digest(ERRORS)
    append_to(copy / "femic/ic_errors/error_measure.py")
    assert anew(ERRORS) != before
    assert code_digest.__wrapped__() == code_digest()
    assert Store().key("harmonic", 1) == models


IMPORTED = {  # by what a module imports: a file that counts for it
    "itself": (FE_CONTACT, "femic/results/finite_elements.py"),
    "module": (FE_CONTACT, "femic/contact/finite_elements/result.py"),
    "module of a module": (FE_CONTACT, "femic/contact/finite_elements/coupling.py"),
    "package of a module": (FE_CONTACT, "femic/contact/finite_elements/__init__.py"),
    "module from a package": (
        "compare.validation.statements.registry",
        "compare/validation/statements/sn.py",
    ),
    "readers of scenes": (ERRORS, "femic/scenes/load.py"),
}
OTHERS = {  # modules that others do not need
    "friction, for contact by finite elements": (FE_CONTACT, "femic/contact/friction/coulomb.py"),
    "contact, for ICs": (ERRORS, "femic/contact/normal.py"),
    "the public interface, which only type checkers import": (ERRORS, "femic/interface/ics.py"),
    "fatigue, for scenes that have its coefficients": (FE_CONTACT, "femic/damage/dang_van.py"),
    "pages": ("compare.pages.frontier", "compare/report/looks.py"),
    "commands": (ERRORS, "femic/cli/main.py"),
}


@pytest.mark.parametrize(("module", "file"), IMPORTED.values(), ids=IMPORTED)
def test_what_a_module_imports_counts(copy, module, file):
    before = anew(module)
    append_to(copy / file)
    assert anew(module) != before


@pytest.mark.parametrize(("module", "file"), OTHERS.values(), ids=OTHERS)
def test_what_it_does_not_import_does_not(copy, module, file):
    before = anew(module)
    append_to(copy / file)
    assert anew(module) == before


def test_a_module_that_imports_more_has_another_digest(copy):
    before = anew(ERRORS)
    path = copy / "femic/ic_errors/error_measure.py"
    path.write_text(path.read_text(encoding="utf-8") + "\nimport femic.contact.normal\n", encoding="utf-8")
    of_import = anew(ERRORS)
    assert of_import != before
    append_to(copy / "femic/contact/normal.py")
    assert anew(ERRORS) != of_import


READERS = "geometries/profiles/text.py"


def test_readers_of_profiles_change_results_of_scenes_but_no_models(copy):
    """Scenes read profiles; a model has its contours."""
    before = anew(ERRORS)
    append_to(copy / READERS)
    assert anew(ERRORS) != before
    assert code_digest.__wrapped__() == code_digest()


@pytest.mark.parametrize("file", ["geometries/contours.py", "approx/forms.py", "femic/reference/discount.py"])
def test_models_depend_on_contours_forms_and_engines(copy, file):
    append_to(copy / file)
    assert code_digest.__wrapped__() != code_digest()


def test_models_know_nothing_of_compare():
    assert not any("compare" in pattern for pattern in OF_MODELS)
    assert code_digest() != results_digest(ERRORS)
    assert code_digest.__wrapped__() == code_digest()


def test_results_depend_on_the_code_of_models(monkeypatch):
    before = results_digest(ERRORS)
    monkeypatch.setattr(digests, "code_digest", lambda: "0123456789ab")
    assert anew(ERRORS) != before


def test_results_depend_on_the_library_that_writes_them(monkeypatch):
    before = results_digest(ERRORS)
    monkeypatch.setattr(digests, "version", lambda _: "0.0")
    assert anew(ERRORS) != before
