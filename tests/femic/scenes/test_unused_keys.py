"""Keys that nobody wrote stop no calculation without use for them: a contact by A needs no lines."""

import pytest

import femic
from femic.cli.main import WRONG_INPUT, exit_code
from femic.scenes.errors import BadScene
from femic.scenes.load import load_scene

ON_LINES = r"lines\.0 \(s = 1\.6 mm\): reaches"
BODY = "[{}]\nE = 210e3\nnu = 0.28\ncontour = {}\n"
SMALL = (
    BODY.format("lower", '{ kind = "arc", radius = 0.05, flank_inclination_deg = 40 }')
    + BODY.format("upper", '{ kind = "plane" }')
    + "rolling_radius = 20.0\n[contact]\nloads = [1e-3]\nelements = 8\n"
)
A_ALONE = SMALL + 'ics = ["A"]\n'


@pytest.fixture
def write(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)

    def written(text):
        (tmp_path / "mine.toml").write_text(text, encoding="utf-8")
        return "mine.toml"

    return written


def test_a_contact_by_a_alone_is_taken_and_one_with_c_or_lines_refused(write):
    load_scene(write(A_ALONE))
    for text in (SMALL, "[[lines]]\nalong = 'x'\ns = 1.6\n" + A_ALONE):
        with pytest.raises(BadScene, match=ON_LINES):
            load_scene(write(text))


@pytest.mark.parametrize("command", ["run", "frontier --components nn", "advise --want p_max", "calibrate"])
def test_commands_that_need_lines_refuse_the_scene(command, write, capsys):
    name, *options = command.split()
    assert exit_code([name, write(A_ALONE), *options, "--workers", "1"]) != 0
    assert "lines.0 (s = 1.6 mm): reaches" in capsys.readouterr().err.replace("\n", " ")


def test_plan_refuses_what_is_not_possible_and_shows_the_rest(write, capsys):
    assert exit_code(["plan", write(A_ALONE)]) == 0
    said = capsys.readouterr().out
    assert "femic run: mine: 3 error(s)" in said
    assert "no C: seconds" in said


def test_a_campaign_of_errors_refuses_it_before_the_run(write, tmp_path, capsys):
    write(A_ALONE)
    sweep = "[sweep.nu]\nkeys = ['lower.nu']\nvalues = [0.2, 0.3]\n"
    (tmp_path / "all.toml").write_text(f"scene = 'mine.toml'\n{sweep}", encoding="utf-8")
    assert exit_code(["sweep", "all.toml", "--workers", "1"]) == WRONG_INPUT
    assert "lines.0" in capsys.readouterr().err


def test_contact_in_python_is_the_same_at_any_scale():
    """All lengths larger by one factor and loads by its square: the same pressures, but for room."""
    steel, p_max = femic.Material(210e3, 0.28), []
    for scale in (1.0, 1000.0):
        rail = femic.Body(femic.arc(0.05 * scale, 40.0), steel)
        wheel = femic.Body(femic.plane(), steel, rolling_radius=20.0 * scale)
        motion, setup = femic.Frictionless(loads=[1e-3 * scale**2]), femic.ContactSetup(elements=8)
        found = femic.solve_contact(femic.Pair(wheel, rail), motion, ["A"], setup)
        p_max.append(float(found.p_max.squeeze()))
    assert p_max[0] == pytest.approx(p_max[1], rel=1e-3)
