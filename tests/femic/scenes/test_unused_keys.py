"""Keys that nobody wrote stop no calculation without use for them: a contact by A needs no lines."""

import numpy as np
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


def test_plan_and_campaigns_say_what_is_not_possible_before_the_run(write, tmp_path, capsys):
    assert exit_code(["plan", write(A_ALONE)]) == 0
    said = capsys.readouterr().out
    assert "femic run: mine: 3 error(s)" in said
    assert "no C: seconds" in said
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


def ball_on_plane(nu=0.28, radius=2.0):
    """Crossed cylinders of the same radius [mm]: in contact a ball on a plane."""
    rail = femic.Body(femic.arc(radius, 60.0), femic.Material(210e3, nu))
    return femic.Pair(femic.Body(femic.plane(), rail.material, rolling_radius=radius), rail)


def test_a_small_ball_has_a_contact_by_a_and_no_c_or_stresses(write, capsys):
    """Limits of engines are those of C and stresses: a ball of 4 mm by A is that of Hertz."""
    load, radius = 10.0, 2.0  # N, mm
    pair, motion = ball_on_plane(radius=radius), femic.Frictionless(loads=[load])
    found = femic.solve_contact(pair, motion, ["A"])
    modulus = 210e3 / (2 * (1 - 0.28**2))
    hertz = (6 * load * modulus**2 / (np.pi**3 * radius**2)) ** (1 / 3)
    assert float(found.p_max.squeeze()) == pytest.approx(hertz, abs=float(found.estimate_p_max.squeeze()))
    with pytest.raises(femic.WrongInput, match=r"upper\.rolling_radius = 2: .* \(no engine .* below 20"):
        femic.solve_contact(pair, motion, ["A", "C"])
    text = A_ALONE.replace("radius = 20.0", "radius = 2.0")
    assert exit_code(["stresses", write(text), "--workers", "1"]) == WRONG_INPUT
    assert "upper.rolling_radius = 2: use A, B or Bhat without stresses" in capsys.readouterr().err


def test_what_needs_an_engine_refuses_what_it_does_not_solve():
    """Nearly incompressible bodies are beyond the solid engine: only C and stresses ask for it."""
    options = femic.Options(engine="solid")
    motion, pair = femic.Frictionless(loads=[10.0]), ball_on_plane(nu=0.495, radius=60.0)
    femic.solve_contact(pair, motion, ["A"], femic.ContactSetup(elements=8), options)
    for compute in (
        lambda: femic.compute_matrix(pair, femic.Grid(4, 4, 0.1, 0.1), "C", options),
        lambda: femic.compute_ics(pair, femic.Patch(0.1, 0.1), [femic.line_along_x(0.2)], options=options),
        lambda: femic.solve_contact(pair, motion, ["A", "C"], options=options),
    ):
        with pytest.raises(femic.WrongInput, match=r"lower\.nu = 0\.495: use engine\.kind = 'harmonic'"):
            compute()
