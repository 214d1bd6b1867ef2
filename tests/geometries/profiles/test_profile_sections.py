import numpy as np
import pytest
from profile_texts import block_text, rail

from geometries.errors import WrongInput
from geometries.profiles.files import read_profile
from geometries.profiles.sections import SectionChoice, read_section, read_sections

LIST = """! a crossing
  2.0  1000.0      % S_OFFSET, S_SCALE
  3                % number of sections
  4 1 2            % features, kinks, accelerations
  2                % approximating
  -1.0  'a.prr'
   0.5  'sub\\b.prr'
   3.0  'a.prr'    " again
  2
  1 2
  -1.0   0.0 10.0 -1 20.0
   0.5   0.0 10.5 12.0 20.0
   3.0  -1   10.0 12.0 20.0
"""


def shifted(k):
    return rail() + np.array([[k], [0.0]])


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "sub").mkdir()
    for k, name in enumerate(("a.prr", "sub/b.prr")):
        (tmp_path / name).write_text(block_text(shifted(k) * [[1.0], [-1.0]]))
    return tmp_path


def save(folder, text, name="list.slcs"):
    path = folder / name
    path.write_text(text)
    return path


def test_a_list_gives_positions_profiles_and_features_or_none(folder):
    sections = read_sections(save(folder, LIST))
    positions = [section.position for section in sections.sections]
    np.testing.assert_allclose(positions, [1000 * (2 + s) for s in (-1.0, 0.5, 3.0)], rtol=1e-15)
    for section, shift in zip(sections.sections, (0, 1, 0), strict=True):
        np.testing.assert_allclose(section.profile.points, shifted(shift), rtol=0, atol=1e-12)
    assert sections.interpolation == "approximating"
    assert (sections.kinks, sections.accelerations) == ((2,), (1, 2))
    assert [section.features for section in sections.sections] == [
        (0.0, 10.0, None, 20.0),
        (0.0, 10.5, 12.0, 20.0),
        (None, 10.0, 12.0, 20.0),
    ]
    bare = read_sections(save(folder, "0 1\n2\n0 0 0\n1\n0 a.prr\n1 'a.prr'\n"))
    assert (len(bare.sections), bare.interpolation, bare.sections[0].features) == (2, "spline", ())
    assert bare.sections[0].profile is bare.sections[1].profile  # read once


@pytest.mark.parametrize(
    ("old", "new", "line", "word"),
    [
        ("  2.0  1000.0", "  2.0  0.0", 2, "scale"),
        ("  2.0  1000.0", "  2.0", 2, "2 numbers"),
        ("  3   ", "  4   ", 9, "position and 'file'"),
        ("  3   ", "  2.5 ", 3, "whole number"),
        ("  3   ", "  0   ", 3, "from 1"),
        ("  4 1 2", "  4 1", 4, "3 numbers"),
        ("  4 1 2", "  4 1 1", 10, "1 numbers"),
        ("  2                % app", "  3                % app", 5, "from 1 to 2"),
        ("   0.5  'sub", "  -1.5  'sub", 7, "must increase"),
        ("'sub\\b.prr'", "'c.prr'", 7, "No such file"),
        ("'sub\\b.prr'", "'list.slcs'", 7, "read_sections"),
        ("   0.5  'sub\\b.prr'", "   'sub\\b.prr'", 7, "expected"),
        ("  1 2\n", "  1 9\n", 10, "from 1 to 2"),
        ("   0.5   0.0 10.5", "   0.6   0.0 10.5", 12, "differs"),
        ("10.5 12.0 20.0", "10.5 12.0", 12, "5 numbers"),
        ("   3.0  -1   10.0 12.0 20.0\n", "", 13, "cut off"),
        ("   3.0  -1   10.0 12.0 20.0\n", "   3.0  -1   10.0 12.0 20.0\n 1 2\n", 14, "not expected"),
    ],
)
def test_wrong_lists_are_named_by_file_and_line(folder, old, new, line, word):
    assert old in LIST
    path = save(folder, LIST.replace(old, new))
    with pytest.raises(WrongInput) as error:
        read_sections(path)
    assert str(error.value).startswith(f"{path}, line {line}: ")
    assert word in str(error.value)


def test_a_wrong_profile_is_named_by_both_files_and_lines(folder):
    bad = folder / "a.prr"
    bad.write_text(bad.read_text().replace("type = 0", "type = 7"))
    path = save(folder, LIST)
    with pytest.raises(WrongInput, match="type = 7") as error:
        read_sections(path)
    assert str(error.value).startswith(f"{path}, line 6: {bad}, line 3: ")


@pytest.mark.parametrize(
    ("read", "name", "message"),
    [
        (read_sections, "a.prr", r"must end in \.slcs"),
        (read_profile, "list.slcs", "read_sections and read_section"),
        (read_sections, "list.slcw", "kind = 'wheel'"),
    ],
)
def test_the_ending_says_what_a_file_is(folder, read, name, message):
    with pytest.raises(WrongInput, match=message):
        read(save(folder, LIST, name))


def test_one_section_by_its_number_or_its_position(folder):
    path = save(folder, LIST)
    for number, position, moved in ((1, 1000.0, 0), (2, 2500.0, 1), (3, 5000.0, 0)):
        for choice in (SectionChoice(number=number), SectionChoice(position=position)):
            profile = read_section(path, choice)
            np.testing.assert_allclose(profile.points, shifted(moved), rtol=0, atol=1e-12)
            assert profile.name == f"list-{number}"
            assert profile.notes[0] == f"Section {number} of 3 of list.slcs, at {position:g}."


def test_only_the_profile_of_the_section_is_read(folder):
    (folder / "sub/b.prr").unlink()
    path = save(folder, LIST)
    assert read_section(path, SectionChoice(number=1)).name == "list-1"
    with pytest.raises(WrongInput, match=r"line 7: .*No such file"):
        read_section(path, SectionChoice(number=2))


@pytest.mark.parametrize(
    ("choice", "word"),
    [
        (SectionChoice(), "give section or section_at"),
        (SectionChoice(1, 1000.0), "give one of both"),
        (SectionChoice(4), r"section = 4: must be 1 \.\.\. 3"),
        (SectionChoice(position=1200.0), "lies between sections, where profiles are not interpolated"),
        (SectionChoice(position=999.0), "lies beyond the list"),
    ],
)
def test_a_section_that_is_none_is_refused_with_those_of_the_list(folder, choice, word):
    with pytest.raises(WrongInput, match=word) as error:
        read_section(save(folder, LIST), choice)
    assert str(error.value).endswith(
        "list.slcs has 1: at 1000, a.prr; 2: at 2500, sub\\b.prr; 3: at 5000, a.prr"
    )


def test_long_lists_are_abridged_in_messages(folder):
    rows = "".join(f"{k} a.prr\n" for k in range(9))
    with pytest.raises(WrongInput, match=r"5: at 4, a\.prr; \.\.\.; 9: at 8, a\.prr$"):
        read_section(save(folder, f"0 1\n9\n0 0 0\n1\n{rows}"), SectionChoice())
