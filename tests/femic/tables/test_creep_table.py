"""The readers of tables: exact for what they interpolate exactly, smooth, the same in Python and in C."""

import re
import shutil
import subprocess
from importlib.resources import files
from pathlib import Path

import numpy as np
import pytest

from femic.results import tables
from femic.scenes.load import load_scene
from femic.tables import creep_table, refinement
from femic.tables.columns import CONTACT, FORCES
from femic.tables.creep_table import AXES, Table, read, slope, stencil

READER = creep_table.__file__

NODES = {
    "shift": [-4.0, -1.0, 0.0, 2.0, 5.0],
    "load": [4e4, 6e4, 1e5, 1.1e5],
    "friction": [0.1, 0.3, 0.6],
    "spin": [-1.0, 0.1, 1.0],
    "angle": 2 * np.pi * np.arange(12) / 12,
    "creepage": [0.0, 0.1, 0.25, 0.4, 0.6, 0.8, 1.0],
}
LOGS = {name for name, (_, scale, _, _) in CONTACT.items() if scale == "log"}
CONTACTS = {
    "normal_force": lambda shift, load: 1.02 * load + 0 * shift,
    "contact_angle": lambda shift, load: 0.03 * shift + 0 * load,
    "creepage_scale": lambda shift, load: 3e-3 * (load / 1e5) ** (1 / 3) + 0 * shift,
    "half_size": lambda shift, load: 6.0 * (load / 1e5) ** (1 / 3) + 0 * shift,
    "free_creepage": lambda shift, load: -1e-3 * shift + 0 * load,
    "p_max": lambda shift, load: 900 * (load / 1e5) ** (1 / 3) + 0 * shift,
    "approach": lambda shift, load: 0.05 * (load / 1e5) ** (2 / 3) + 0 * shift,
    "y": lambda shift, load: -3.0 * shift + 0 * load,
    "z": lambda shift, load: -0.1 * shift**2 + 0 * load,
}


def share(number, *at):
    """A smooth function of all axes: a quadratic of the first four, of a vector for the last two."""
    shift, load, friction, spin, angle, creepage = at
    along, across = creepage * np.cos(angle), creepage * np.sin(angle)
    outer = (1 + 0.02 * shift**2) * (1 + 0.1 * np.log(load / 1e5)) * (1 - friction) * (1 + 0.3 * spin**2)
    return outer * (number + along - 0.5 * across + 0.2 * along * across - 0.3 * along**2)


def make(nodes=NODES, function=share):
    grid = np.meshgrid(*(nodes[axis] for axis in AXES), indexing="ij")
    outer = np.meshgrid(nodes["shift"], nodes["load"], indexing="ij")
    contacts = {name: quantity(*outer) for name, quantity in CONTACTS.items()}
    return Table(nodes, contacts, LOGS, {name: function(k, *grid) for k, name in enumerate(FORCES, 1)})


def written(table, path):
    """Write a table as text, as the program does."""
    words = ["femic-creep-table 1  # a comment 1 2 3"]
    for axis in AXES:
        words += [axis, len(table.axes[axis]), *table.axes[axis]]
    words.append(len(table.names))
    for name, values in zip(table.names, table.quantities, strict=True):
        logarithmic = name in table.logarithmic
        own = np.exp(values) if logarithmic else values
        words += [name, "log" if logarithmic else "linear", *own.ravel()]
    words.append(len(table.force_names))
    for name, values in zip(table.force_names, table.values, strict=True):
        words += [name, *values.ravel()]
    path.write_text("\n".join(map(str, [*words, "end"])))
    return path


def somewhere(random, count):
    low, high = np.array([(NODES[axis][0], NODES[axis][-1]) for axis in AXES[:4]]).T
    for _ in range(count):
        yield (*random.uniform(low, high), random.uniform(-9, 9), random.uniform(0, 1))


def test_quadratics_are_exact_along_each_axis_and_contacts_are_powers_of_the_load():
    table, fine = make(), NODES | {"angle": 2 * np.pi * np.arange(720) / 720}
    by_angle = make({**fine, "shift": [0.0], "load": [1e5], "friction": [0.1], "spin": [0.1]})
    random = np.random.default_rng(1)
    for at in somewhere(random, 50):
        polar = (0.0, 1e5, 0.1, 0.1, *at[4:])
        expected = [share(k, *polar) for k in range(1, 7)]
        assert [*by_angle.shares(*polar).values()] == pytest.approx(expected, abs=2e-8)
        on_ray = (*at[:4], NODES["angle"][5], at[5])
        expected = [share(k, *on_ray) for k in range(1, 7)]
        assert [*table.shares(*on_ray).values()] == pytest.approx(expected, abs=1e-12)
        found = table.contact(*at[:2])
        for name, quantity in CONTACTS.items():
            assert found[name] == pytest.approx(quantity(*at[:2]), rel=1e-10, abs=1e-12), name


def test_errors_fall_as_the_third_power_of_the_step_or_faster():
    def wave(number, *at):
        angle, creepage = at[4:]
        return np.sin(number + 3 * creepage * np.cos(angle) + 2 * creepage * np.sin(angle))

    errors = []
    for count in (16, 32, 64):
        axes = {"angle": 2 * np.pi * np.arange(count) / count, "creepage": np.linspace(0, 1, count + 1)}
        outer = {"shift": [0.0], "load": [1.0], "friction": [0.3], "spin": [0.0]}
        table, random = make(outer | axes, wave), np.random.default_rng(2)
        places = [(0.0, 1.0, 0.3, 0.0, random.uniform(-4, 4), random.uniform(0, 1)) for _ in range(200)]
        errors.append(max(abs(table.shares(*at)["f_x"] - wave(1, *at)) for at in places))
    assert np.all(np.log2(np.array(errors[:-1]) / errors[1:]) > 2.9)


@pytest.mark.parametrize("axis", range(6))
def test_values_and_slopes_are_continuous_at_nodes(axis):
    """Also without creepage, on each line through it: opposite angles are one line."""
    table = make(function=lambda k, *at: np.random.default_rng(k).uniform(size=at[0].shape))
    own, random, h = NODES[AXES[axis]], np.random.default_rng(3), 1e-6
    for place in somewhere(random, 20):
        node = own[random.integers(1, len(own) - 1)]
        step = h * (own[-1] - own[0])
        at = [[*place[:axis], node + move * step, *place[axis + 1 :]] for move in (-2, -1, 0, 1, 2)]
        values = np.array([table.shares(*each)["f_y"] for each in at])
        assert np.ptp(values) < 50 * h
        before, after = (values[1] - values[0]) / h, (values[4] - values[3]) / h
        assert before == pytest.approx(after, abs=2e-3)


def test_slopes_are_continuous_through_zero_creepage():
    def rough(k, *at):
        values = np.random.default_rng(k).uniform(size=at[0].shape)
        values[..., 0] = values[..., :1, 0]  # the same at all angles
        return values

    table, h = make(function=rough), 1e-6
    for angle in (0.0, 0.3, 2.0, 5.5):
        ahead, behind = (
            [table.shares(1.0, 5e4, 0.2, 0.0, angle + turn, size)["f_x"] for size in (h, 2 * h)]
            for turn in (0, np.pi)
        )
        assert ahead[1] - ahead[0] == pytest.approx(behind[0] - behind[1], abs=1e-9)
        assert abs(ahead[1] - ahead[0]) > 1e-8


def test_forces_turn_with_the_contact_angle_and_scale_with_friction():
    table = make(function=lambda k, *at: np.full(at[0].shape, [0.0, 0.3, -0.4, 1.1, 0.2, 1.01, 0.5][k]))
    found = table.forces(2.0, 1e5, 0.3, longitudinal=-2e-3 + 1e-3, lateral=0.0, spin=0.0)
    normal, angle = 1.02e5, 0.06
    f_s, f_n = -0.4 * 0.3 * normal, 1.1 * normal
    assert found["F_x"] == pytest.approx(0.3 * 0.3 * normal)
    assert found["F_y"] == pytest.approx(f_s * np.cos(angle) - f_n * np.sin(angle))
    assert found["F_z"] == pytest.approx(f_s * np.sin(angle) + f_n * np.cos(angle))
    assert found["M_n"] == pytest.approx(0.2 * 0.3 * normal * 6.0)
    assert found["p_max"] == pytest.approx(1.01 * 900)
    saturation = 0.3 * 3e-3
    assert found["work"] == pytest.approx(0.5 * 0.3 * normal * (saturation + 1e-3))


@pytest.mark.parametrize(
    ("name", "at"),
    [
        ("shift", (5.1, 5e4, 0.3)),
        ("load", (0.0, 3.9e4, 0.3)),
        ("friction", (0.0, 5e4, 0.05)),
        ("shift", (np.nan, 5e4, 0.3)),
    ],
)
def test_what_is_not_in_the_table_is_refused(name, at):
    with pytest.raises(ValueError, match=f"{name} = .*: the table has "):
        make().forces(*at, longitudinal=0.0)


def test_spin_beyond_the_table_is_refused_and_the_ends_are_not():
    table = make()
    limit = 0.3 * 3e-3 / 6.0
    table.forces(0.0, 1e5, 0.3, 0.0, 0.0, limit)
    with pytest.raises(ValueError, match="spin"):
        table.forces(0.0, 1e5, 0.3, 0.0, 0.0, 1.01 * limit)


def test_a_file_gives_the_table_and_half_a_file_none(tmp_path):
    table = make()
    path = written(table, tmp_path / "table.txt")
    again = read(path)
    for at in somewhere(np.random.default_rng(4), 20):
        assert again.shares(*at) == pytest.approx(table.shares(*at), abs=1e-12)
    words = path.read_text().split()
    for damaged in (
        words[: len(words) // 2],
        words[:-1],
        ["other", *words[1:]],
        [word.replace("load", "lode") for word in words],
        [*words[:60], "x", *words[61:]],
    ):
        (tmp_path / "damaged.txt").write_text(" ".join(damaged))
        with pytest.raises(ValueError, match=r"damaged\.txt: no table of femic"):
            read(tmp_path / "damaged.txt")


# --- C ---

PROGRAM = r"""
#include "creep_table.h"
int main(int count, char **names) {
    double at[6], forces[CREEP_FORCES], contact[CREEP_CONTACT];
    creep_table *table = count > 1 ? creep_table_read(names[1]) : NULL;
    if (!table) { puts("no table"); return 1; }
    while (scanf("%lf %lf %lf %lf %lf %lf", at, at + 1, at + 2, at + 3, at + 4, at + 5) == 6) {
        int failed = creep_table_forces(table, at[0], at[1], at[2], at[3], at[4], at[5], forces);
        printf("%d", failed);
        for (int k = 0; !failed && k < CREEP_FORCES; k++) printf(" %.12g", forces[k]);
        failed = creep_table_contact(table, at[0], at[1], contact);
        for (int k = 0; !failed && k < CREEP_CONTACT; k++) printf(" %.12g", contact[k]);
        puts("");
    }
    creep_table_free(table);
    return 0;
}
"""


@pytest.fixture(scope="module")
def program(tmp_path_factory):
    """A C program that reads a table, and forces at places from its input."""
    compiler = shutil.which("cc") or shutil.which("gcc")
    if compiler is None:
        pytest.skip("no C compiler")
    folder = tmp_path_factory.mktemp("c")
    (folder / "creep_table.h").write_text(files("femic.tables").joinpath("creep_table.h").read_text())
    (folder / "program.c").write_text(PROGRAM)
    strict = ["-std=c99", "-O1", "-Wall", "-Wextra", "-Werror", "-pedantic"]
    command = [compiler, *strict, "program.c", "-o", "program", "-lm"]
    subprocess.run(command, cwd=folder, check=True, capture_output=True)
    return folder / "program"


def run(program, path, places):
    text = "\n".join(" ".join(f"{value:.17g}" for value in at) for at in places)
    done = subprocess.run([program, path], input=text, capture_output=True, text=True, check=False)
    lines = [line.split() for line in done.stdout.splitlines() if line[0].isdigit()]
    return done.returncode, [[float(word) for word in line] for line in lines]


@pytest.mark.parametrize("single", [(), ("load", "friction"), ("shift", "load", "friction", "spin")])
def test_c_gives_what_python_gives(program, tmp_path, single):
    nodes = {axis: NODES[axis][:1] if axis in single else NODES[axis] for axis in AXES}
    nodes |= {"spin": [0.0]} if "spin" in single else {}
    table, random = make(nodes), np.random.default_rng(5)
    path, places = written(table, tmp_path / "table.txt"), []
    for _ in range(60):
        outer = [random.uniform(nodes[axis][0], nodes[axis][-1]) for axis in AXES[:3]]
        spin = 0.0 if "spin" in single else random.uniform(-0.9, 0.9) * 1e-5
        places.append([*outer, random.normal() * 4e-3, random.normal() * 4e-3, spin])
    places += [[*places[0][:3], -1e-3 * places[0][0], 0.0, 0.0], [99.0, *places[0][1:]]]
    status, lines = run(program, path, places)
    assert status == 0
    for at, (failed, *numbers) in zip(places[:-1], lines[:-1], strict=True):
        assert failed == 0
        expected = [*table.forces(*at).values(), *table.contact(*at[:2]).values()]
        assert numbers == pytest.approx(expected, rel=1e-8, abs=1e-6)
    assert lines[-1] == [1.0]  # the first axis


def test_c_refuses_half_a_file_and_names_the_axis(program, tmp_path):
    path = written(make(), tmp_path / "table.txt")
    beyond = [[0.0, 1e3, 0.3, 0, 0, 0], [0.0, 5e4, 3.0, 0, 0, 0], [0.0, 5e4, 0.3, 0, 0, 1.0]]
    assert [line[0] for line in run(program, path, beyond)[1]] == [2, 3, 4]
    path.write_text(path.read_text()[:5000])
    assert run(program, path, beyond) == (1, [])


def test_weights_add_up_and_slopes_are_those_of_lines():
    nodes = np.array([0.0, 1.0, 4.0, 4.5])
    for value in (0.0, 0.7, 2.0, 4.2, 4.5):
        used, weights = stencil(nodes, value)
        assert weights.sum() == pytest.approx(1)
        assert weights @ nodes[used] == pytest.approx(value)
    assert slope(nodes[:3], 4.0) @ nodes[:3] == pytest.approx(1)


# --- the page ---


def blocks(language):
    page = (Path(__file__).parents[3] / "docs/how-to/tables.md").read_text(encoding="utf-8")
    return re.findall(rf"^```{language}\n(.*?)^```$", page, flags=re.DOTALL | re.MULTILINE)


def test_the_page_reads_a_table_in_python_as_it_says(tmp_path, monkeypatch, capsys):
    written(make(), tmp_path / "table.txt")
    shutil.copy(READER, tmp_path)
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(str(tmp_path))
    code = next(block for block in blocks("python") if "import creep_table" in block)
    names = {}
    exec(compile(code, "tables.md", "exec"), names)
    assert names["forces"] == make().forces(1.5, 80e3, 0.3, -1e-3, 2e-4, 0.0)
    assert len(capsys.readouterr().out.split()) == 7
    assert names["creep_table"].__file__ == str(tmp_path / "creep_table.py")


def test_the_page_reads_a_table_in_c_as_it_says(program, tmp_path):
    (code,) = blocks("c")
    include, body = code.split("\n", 1)
    shutil.copy(program.with_name("creep_table.h"), tmp_path)
    body = f"{include}\nint main(void) {{\n{body}\nreturn failed; }}\n"
    (tmp_path / "page.c").write_text(body)
    command = [shutil.which("cc") or "gcc", "-std=c99", "page.c", "-o", "page", "-lm"]
    subprocess.run(command, cwd=tmp_path, check=True, capture_output=True)
    written(make(), tmp_path / "table.txt")
    done = subprocess.run([tmp_path / "page"], cwd=tmp_path, capture_output=True, text=True, check=True)
    expected = make().forces(1.5, 80e3, 0.3, -1e-3, 2e-4, 0.0)
    assert [float(word) for word in done.stdout.split()[:2]] == pytest.approx(
        [expected["F_x"], expected["F_y"]], rel=1e-5
    )


def test_the_scene_of_the_page_has_a_table(tmp_path):
    (tmp_path / "mine.toml").write_text(next(block for block in blocks("toml") if "[lower]" in block))
    scene = load_scene(tmp_path / "mine.toml")
    tables.require_table(scene)
    at_side, mirrored_in_itself = 3 * (8 * 7 + 1), 2 * 7 + 1
    in_middle = (at_side + mirrored_in_itself) // 2
    held_out = refinement.HELD_OUT * refinement.IN_HELD_OUT
    expected = 2 * 2 + refinement.HELD_OUT, 2 * (in_middle + at_side) + held_out
    assert tables.plan_table(scene) == expected
