"""Names of files and folders that lead elsewhere, that are no UTF-8, or that terminals cannot write."""

import io
import sys

import pytest

from femic.cli import doctor
from femic.cli.doctor import Finding
from femic.cli.main import DONE, WRONG_INPUT, exit_code, main
from femic.shifts.specification import example
from tests.samples import write_head

AS_RAIL = ["--kind", "rail", "--axes", "field"]


@pytest.fixture
def place(tmp_path, monkeypatch):
    """The working directory, with a folder of files of results in it."""
    (tmp_path / "work" / "d").mkdir(parents=True)
    monkeypatch.chdir(tmp_path / "work")
    return tmp_path / "work"


def files(folder):
    return sorted(path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file())


@pytest.mark.parametrize("name", ["...txt", ". .txt", "..txt", "bell\x07.txt"])
@pytest.mark.parametrize("command", ["profiles", "shifts"])
def test_names_of_no_folder_are_refused_and_nothing_is_written(name, command, place, capsys):
    if command == "profiles":
        write_head(place / "d" / name)
    else:
        (place / "d" / name).write_text(example(), encoding="utf-8")
    before = files(place.parent)
    options = AS_RAIL if command == "profiles" else ["--write", "0"]
    assert exit_code([command, f"d/{name}", *options]) == WRONG_INPUT
    said = capsys.readouterr().err
    assert repr(f"d/{name}") in said
    assert "rename it" in said
    assert files(place.parent) == before


@pytest.mark.parametrize("words", [["run", "a\udcff.toml"], ["shifts", "s1002-on-60e1", "--out", "\udcfe"]])
def test_names_that_are_no_utf_8_are_refused_before_any_work(words, place, capsys):
    assert exit_code(words) == WRONG_INPUT
    said = capsys.readouterr().err
    assert "is no name in UTF-8: rename the file or folder" in said
    assert "\\udcf" in said
    assert files(place) == []


def test_a_working_directory_that_is_no_utf_8_is_refused(place, monkeypatch, capsys):
    (place / "w\udcff").mkdir()
    monkeypatch.chdir(place / "w\udcff")
    assert exit_code(["scenes"]) == WRONG_INPUT
    assert "w\\udcff" in capsys.readouterr().err


def test_folders_with_brackets_are_printed_as_they_are(place, capsys):
    write_head(place / "mine.txt")
    assert exit_code(["profiles", "mine.txt", *AS_RAIL, "--out", "[/a]"]) == DONE
    assert "Report: [/a]/mine/profile.html" in capsys.readouterr().out


def test_terminals_get_question_marks_for_letters_that_they_do_not_have(monkeypatch):
    finding = Finding("B̂ [/b]", True, "à")
    monkeypatch.setattr(doctor, "findings", lambda: [finding])
    terminal = io.TextIOWrapper(io.BytesIO(), encoding="latin-1")
    monkeypatch.setattr(sys, "stdout", terminal)
    with pytest.raises(SystemExit) as ended:
        main(["doctor"])
    assert ended.value.code == DONE
    terminal.flush()
    said = terminal.buffer.getvalue().decode("latin-1")
    assert "ok  B? [/b]  à" in said
    assert "This installation is in order." in said
