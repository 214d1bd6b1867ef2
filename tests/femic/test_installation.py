"""femic doctor: what is found in this installation, and in damaged ones."""

import base64
import hashlib
from functools import cache
from importlib import metadata
from pathlib import Path
from unittest.mock import Mock

import pytest

import femic
from femic.cli import doctor as installation
from femic.cli.doctor import Finding
from femic.cli.main import OWN_NAMES, exit_code

GOOD = Finding("numpy", True, "2.4")


@pytest.fixture(scope="module", autouse=True)
def _distributions_once():
    """What packages install is read once."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(metadata, "packages_distributions", cache(metadata.packages_distributions))
        yield


def test_import_names_lead_here():
    for name in OWN_NAMES:
        finding = installation.import_name(name)
        assert (finding.holds, Path(finding.text).name) == (True, name)


def test_a_name_that_leads_elsewhere_or_that_another_package_installs_is_told(monkeypatch, tmp_path):
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "elsewhere" / "__init__.py").touch()
    monkeypatch.syspath_prepend(tmp_path)
    assert not installation.import_name("elsewhere").holds
    monkeypatch.setattr(metadata, "packages_distributions", lambda: {"compare": ["compare", "femic"]})
    finding = installation.import_name("compare")
    assert not finding.holds
    assert "also of the package compare" in finding.text
    assert "virtual environment" in finding.remedy


@pytest.mark.parametrize(("content", "holds"), [("x = 1\n", True), ("x = 2\n", False), (None, False)])
def test_changed_and_missing_files_are_told(monkeypatch, tmp_path, content, holds):
    digest = base64.urlsafe_b64encode(hashlib.sha256(b"x = 1\n").digest()).rstrip(b"=").decode()
    file = metadata.PackagePath("femic/one.py")
    file.hash, file.dist = metadata.FileHash(f"sha256={digest}"), None
    monkeypatch.setattr(metadata.PackagePath, "locate", lambda _: tmp_path / "one.py", raising=False)
    monkeypatch.setattr(metadata, "files", lambda _: [file])
    if content is not None:
        (tmp_path / "one.py").write_text(content, encoding="utf-8")
    finding = installation.unchanged_files()
    assert finding.holds is holds
    assert holds or "femic/one.py" in finding.text


@pytest.mark.parametrize(
    ("line", "extra", "holds", "matters"),
    [
        ("numpy>=2", "", True, True),
        ("numpy<1", "", False, True),
        ("a-library-that-is-not-there>=1", "", False, True),
        ("a-library-that-is-not-there>=1; extra == 'direct'", "direct", False, False),
        ("pytest>=1; extra == 'dev'", "dev", None, None),
    ],
)
def test_libraries_are_compared_with_what_femic_requires(monkeypatch, line, extra, holds, matters):
    monkeypatch.setattr(metadata, "requires", lambda _: [line])
    findings = list(installation.dependencies())
    assert [(one.holds, one.matters) for one in findings] == ([] if holds is None else [(holds, matters)])
    assert holds is not False or "pip install" in findings[0].remedy
    assert matters is not False or f"femic[{extra}]" in findings[0].remedy


def test_a_known_number_is_within_its_tolerance_and_an_error_is_a_finding():
    for value, holds in ((1.009, True), (1.011, False), (0.98, False)):
        assert installation.self_test("", "", lambda value=value: (value, 1.0), 0.01).holds is holds
    finding = installation.self_test("", "", Mock(side_effect=femic.Failure("no memory")), 0.01)
    assert not finding.holds
    assert "no memory" in finding.text


@pytest.mark.slow  # 10 s
@pytest.mark.parametrize("test", installation.SELF_TESTS, ids=lambda test: test[0])
def test_the_self_tests_hold_here(test):
    assert installation.self_test(*test).holds


@pytest.mark.parametrize(
    ("more", "code"),
    [
        ([], 0),
        ([Finding("3D", False, "no screen", "apt-get install x", matters=False)], 0),
        ([Finding("scipy", False, "not installed", "pip install 'scipy[a]'")], 1),
    ],
)
def test_doctor_fails_on_what_matters(monkeypatch, capsys, more, code):
    monkeypatch.setattr("femic.cli.doctor.findings", lambda: [GOOD, *more])
    assert exit_code(["doctor"]) == code
    printed = capsys.readouterr()
    assert "numpy" in printed.out
    for finding in more:
        assert finding.remedy in printed.out
    assert ("this installation has problems: scipy" in printed.err) is bool(code)


def test_a_part_of_femic_that_cannot_be_imported_leads_to_doctor(monkeypatch, capsys):
    broken = Mock(side_effect=ImportError("cannot import name 'page'", name="compare.contact"))
    monkeypatch.setattr("femic.cli.doctor.findings", broken)
    assert exit_code(["doctor"]) == 1
    message = capsys.readouterr().err
    assert "cannot import name 'page'" in message
    assert "femic doctor" in message
    broken.side_effect.name = "scipy.sparse"
    with pytest.raises(ImportError):
        exit_code(["doctor"])
