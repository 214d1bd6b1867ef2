"""The file that specifies a wheelset: its keys, what is refused, and the example."""

import tomllib

import numpy as np
import pytest
from worn_profiles import unworn

from femic.reference.run_options import RunOptions
from femic.results.wheelset_contacts import Study
from femic.shifts.sides import doubts, lay_out_wheelset, prepare_sections, understood
from femic.shifts.specification import builtin_names, example, load_shifts
from geometries.errors import WrongInput
from geometries.profiles.files import write_profile
from geometries.profiles.standards import standard_profile
from tests.samples import ERROR, write_head

MINIMAL = '[rail]\nprofile = "60E1"\n[wheel]\nprofile = "S1002"\n'


def loaded(tmp_path, text):
    path = tmp_path / "own.toml"
    path.write_text(text)
    return load_shifts(str(path))[2]


def test_the_least_that_must_be_said(tmp_path):
    file = loaded(tmp_path, MINIMAL)
    assert file.shifts == tuple(range(-8, 9))
    assert file.contact.load == 90_000
    assert file.rails[0] == file.rails[1]


def test_wheels_may_have_two_radii(tmp_path):
    """The tape circles lie at half of the flange-back distance and 70 mm, 459 and 460.5 mm below the axle."""
    one = loaded(tmp_path, f"{MINIMAL}flange_back = -70\n[wheelset]\nnominal_radius = 459\n")
    two = loaded(tmp_path, f"{MINIMAL}flange_back = -70\n[wheelset]\nnominal_radius = [459, 460.5]\n")
    assert one.wheelset.nominal_radius == (459, 459)
    layout = lay_out_wheelset(two)
    assert layout.nominal_radius == (459, 460.5)
    for side, radius in ((layout.left, 459), (layout.right, 460.5)):
        np.testing.assert_allclose(side.tape, [750, -radius], rtol=0, atol=1e-9)
    assert Study(one, lay_out_wheelset(one), RunOptions()).alike
    assert not Study(two, layout, RunOptions()).alike
    for wrong, says in (
        ("[459]", r"nominal_radius.1: Field required"),
        ("[1, 460]", r"nominal_radius.0 = 1: Input should be at least 20"),
        ("5000", r"nominal_radius.0 = 5000: Input should be at most 2000"),
        ('"large"', r"nominal_radius = 'large': Input should be a list"),
    ):
        with pytest.raises(WrongInput, match=says):
            loaded(tmp_path, f"{MINIMAL}[wheelset]\nnominal_radius = {wrong}\n")


@pytest.mark.parametrize("name", builtin_names())
def test_the_example_shows_every_key_and_is_the_built_in_file(name):
    text = example(name)
    from_example, from_file = tomllib.loads(text), load_shifts(name)[2]
    assert from_example["rail"]["profile"] == from_file.rail.profile
    assert tuple(from_example["shifts"]) == from_file.shifts
    commented = "\n".join(line.removeprefix("# ") for line in text.splitlines())
    for table in (from_file, from_file.rail, from_file.wheel, from_file.contact, from_file.track):
        for key in type(table).model_fields:
            assert f"{key} = " in commented or f"[{key}]" in commented, key


def test_the_example_says_that_c_is_solved_only_where_it_is_given(tmp_path):
    (line,) = (line for line in example().splitlines() if line.startswith("c_above_deg"))
    assert line.endswith("without this key C is not used")
    assert loaded(tmp_path, MINIMAL).contact.c_above_deg is None


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (MINIMAL.replace("60E1", "S1002"), "is no rail"),
        (
            MINIMAL.replace("60E1", "nothing.prr"),
            "neither a file relative to the specification nor a built-in profile",
        ),
        (MINIMAL + "[contact]\nload = -1.0\n", r"contact\.load = -1\.0: must be positive \[N\]"),
        (MINIMAL + "[contact]\nload = 0\n", "must be positive"),
        (MINIMAL + '[contact]\nics = ["D"]\n', "contact.ics"),
        (
            "shifts = [1.0, 0.0]\n" + MINIMAL,
            r"shifts = \[1\.0, 0\.0\]: 0 comes after 1: shifts must increase; sort them",
        ),
        ("shifts = [60.0]\n" + MINIMAL, "at most 50"),
        (MINIMAL.replace('60E1"', '60E1"\ntolerance = 0.02'), "only for files"),
        (MINIMAL.replace('60E1"', '60E1"\nsection = 2'), "rail.section: only for files"),
        (MINIMAL + "[track]\ngage = 1435.0\n", "unknown key"),
        ("[rail", "not TOML"),
    ],
)
def test_wrong_files_are_refused(tmp_path, text, says):
    with pytest.raises(WrongInput, match=says):
        loaded(tmp_path, text)


def test_a_missing_file_names_the_way_to_an_example():
    with pytest.raises(WrongInput, match="--show"):
        load_shifts("no-such.toml")


def test_profiles_of_files_and_standards_are_the_same(tmp_path):
    """The standard rail written to a file; a spline through points 0.1 mm apart."""
    write_profile(standard_profile("60E1", 0.1), tmp_path / "rail.prr")
    of_file = loaded(tmp_path, MINIMAL.replace("60E1", "rail.prr"))
    exact = loaded(tmp_path, MINIMAL)
    t = np.linspace(10, 110, 500)
    one, other = (lay_out_wheelset(file).left.rail.position(t) for file in (of_file, exact))
    np.testing.assert_allclose(one, other, rtol=0, atol=1e-3)  # arc lengths differ at corners of the spline
    assert any("rail" in note for note in understood(prepare_sections(of_file), lay_out_wheelset(of_file)))


def test_a_section_of_a_list_is_a_profile(tmp_path):
    """The second section is 60E1; the first one, 54E1, has another curve."""
    for name, section in (("a.prr", "54E1"), ("b.prr", "60E1")):
        write_profile(standard_profile(section, 0.1), tmp_path / name)
    (tmp_path / "track.slcs").write_text("0 1000\n2\n0 0 0\n1\n0 'a.prr'\n1.5 'b.prr'\n")
    exact = prepare_sections(loaded(tmp_path, MINIMAL))[0].curve
    for key in ("section = 2", "section_at = 1500.0"):
        section = prepare_sections(loaded(tmp_path, MINIMAL.replace('60E1"', f'track.slcs"\n{key}')))[0]
        assert section.name == "track-2"
        np.testing.assert_allclose(
            section.curve.position(np.linspace(10, 110, 50)),
            exact.position(np.linspace(10, 110, 50)),
            atol=1e-3,
        )
    with pytest.raises(WrongInput, match=r"give section or section_at; track\.slcs has 1: at 0"):
        prepare_sections(loaded(tmp_path, MINIMAL.replace("60E1", "track.slcs")))


def test_the_worn_pair_keeps_its_gauge():
    """Rails worn in their place are where the built-in specification lays them out, to 0.05 mm."""
    left = lay_out_wheelset(load_shifts("s1002-on-60e1-worn")[2]).left
    unworn_left = unworn().left
    assert left.rail.offset[0] == pytest.approx(unworn_left.rail.offset[0], abs=0.05)
    assert left.wheel.offset[0] == pytest.approx(unworn_left.wheel.offset[0], abs=1e-9)
    assert left.rail.angle == unworn_left.rail.angle


@pytest.mark.parametrize(("tolerance", "is_noisy"), [(0.0, True), (ERROR, False)])
def test_what_looks_like_noise_is_said_once_for_both_sides(tmp_path, tolerance, is_noisy):
    """Errors of alternating sign bend the curve far more than an arc of 30 mm."""
    write_head(tmp_path / "mine.txt")
    rail = f'[rail]\nprofile = "mine.txt"\naxes = "field"\ntolerance = {tolerance}\n'
    found = doubts(prepare_sections(loaded(tmp_path, rail + '[wheel]\nprofile = "S1002"\n')))
    assert len(found) == is_noisy
    assert all(doubt.startswith("left rail, mine: The least radius is 0") for doubt in found)
