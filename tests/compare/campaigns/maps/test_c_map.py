"""Maps of C. In these tests it is B-hat and a function of the swept keys: polynomials are found exactly."""

import shutil
from functools import cache
from types import SimpleNamespace

import h5py
import numpy as np
import pytest
import xarray as xr

from compare.campaigns import kinds
from compare.campaigns.maps import bhat_for_map, maps_of_scene, open_map
from compare.report.looks import ics_symbol
from femic.contact.pairs import ics as reference_ics
from femic.contact.pairs.grids import grids_of
from femic.contact.pairs.ics import GivenICs
from femic.contact.pairs.pair_on_grid import pair_on_grid
from femic.results.contact import compute_contact, reference_name
from femic.results.friction import compute_with_friction
from femic.scenes.errors import BadScene
from femic.scenes.load import load_scene
from geometries.errors import Failure, WrongInput
from tests.compare.campaigns.campaigns import campaign_in, collect

BASE = """
bodies = ["combined"]
lower = { E = 210e3, nu = 0.28, contour = { kind = "arc", radius = 10.0, flank_inclination_deg = 60.0 } }
patch = { a = 0.3, b = 0.3 }
grid = { n_x = 10, n_s = 10, dx = 0.7, ds = 0.55 }
contact = { loads = [300], grid = "scene", ics = ["Bhat", "C"] }
[upper]
E = 210e3
nu = 0.28
rolling_radius = 450
contour = { kind = "arc", radius = 10.5, flank_inclination_deg = 60.0 }
"""
CAMPAIGN = """
scene = "base.toml"
keep = ["matrix"]
[sweep.ratio]
keys = { "upper.contour.radius" = 10 }
values = [1.05, 1.1, 1.2, 1.3]
[sweep.E]
keys = ["lower.E", "upper.E"]
spacing = "logarithmic"
values = [1e5, 2e5, 4e5, 7e5, 1e6]
"""
ESTIMATE = 1e-9  # mm/MPa
COUPLED = np.array([[1.0, 0.0, 0.1], [0.0, 0.9, 0.05], [-0.1, 0.05, 0.8]])


def polynomial(ratio, modulus):
    return 0.2 * ratio**2 - 0.1 * ratio + 0.03 * np.log(modulus / 1e5) ** 3


def steep(ratio, modulus):
    return 0.004 * np.exp(2 * ratio) * np.log(modulus / 5e4) ** 4


def c_of(problem, on_grid, f):
    """B-hat, and f times a share of its own ICs that is largest at small lags and on equal strips.

    With friction of all components, in which i and j differ.
    """
    grid, friction = on_grid.grid, problem.specification.friction
    bhat = bhat_for_map(SimpleNamespace(contact=problem.specification), on_grid)
    near = np.exp(-np.abs(np.subtract.outer(grid.strips, grid.strips)))
    shape = f(*ratio_and_modulus(problem)) * np.exp(-grid.lags)[:, None, None] * near
    if friction:
        return bhat + bhat[0, 0, 0, 2, 2] * shape[..., None, None] * COUPLED
    return bhat + bhat[0, 0, 0] * shape


def true_c(scene, f):
    problem = scene.contact_problem
    return c_of(problem, pair_on_grid(problem, scene.grid), f)


def ratio_and_modulus(problem):
    upper, lower = problem.bodies["upper"], problem.bodies["lower"]
    return abs(upper.contour.core.radius) / 10, lower.material.E


@pytest.fixture(scope="module")
def map_of(tmp_path_factory):
    """A function that writes a map of C as a function of the keys, once for equal arguments."""
    return cache(lambda _f, *campaign: write_map(tmp_path_factory.mktemp("map"), *campaign))


def write_map(folder, left_out, base, campaign):
    (folder / "base.toml").write_text(base, encoding="utf-8")
    return collect(campaign_in(folder, campaign), folder / "out", kinds.matrix, left_out)


@pytest.fixture
def make(map_of, tmp_path, monkeypatch):
    """A function that makes a map of C = f(ratio, modulus) times B-hat; returns its name."""

    def make(f=polynomial, left_out=(), base=BASE, campaign=CAMPAIGN):
        def made_ics(problem, on_grid, _options=None, **_rolls):
            c = c_of(problem, on_grid, f)
            return c, np.full_like(c, ESTIMATE)

        for module in (kinds, reference_ics):
            monkeypatch.setattr(module, "normal_ics", made_ics)
        monkeypatch.setattr(kinds, "full_ics", made_ics)
        (tmp_path / "base.toml").write_text(base, encoding="utf-8")
        return f"map:{map_of(f, left_out, base, campaign)}"

    return make


def scene_at(folder, ratio, modulus, **changes):
    keys = {
        "lower": {"E": modulus},
        "upper": {
            "E": modulus,
            "contour": {"kind": "arc", "radius": 10 * ratio, "flank_inclination_deg": 60.0},
        },
    }
    return load_scene(str(folder / "base.toml"), keys | changes)


def read(name, scene):
    return open_map(name, scene).at(pair_on_grid(scene.contact_problem, scene.grid))


@pytest.mark.parametrize(("ratio", "modulus"), [(1.07, 3e5), (1.25, 1.5e5), (1.1, 8e5), (1.29, 9.9e5)])
def test_polynomials_of_the_keys_are_exact(make, tmp_path, ratio, modulus):
    name, scene = make(), scene_at(tmp_path, ratio, modulus)
    ic, estimate = read(name, scene)
    np.testing.assert_allclose(ic, true_c(scene, polynomial), rtol=1e-10)
    np.testing.assert_allclose(estimate, ESTIMATE, rtol=1e-3)


def test_map_is_c_at_nodes_to_rounding(make, tmp_path):
    name, scene = make(steep), scene_at(tmp_path, 1.2, 4e5)
    np.testing.assert_allclose(read(name, scene)[0], true_c(scene, steep), rtol=1e-14)


@pytest.mark.parametrize(("ratio", "modulus"), [(1.07, 3e5), (1.15, 1.4e5), (1.25, 8e5)])
def test_estimate_bounds_the_error_between_nodes(make, tmp_path, ratio, modulus):
    """It is not that of exact values, and not without bounds: seven times for nodes twice as far apart, 2.25
    for kinks that are not there, on two axes, on the steepest of the lines around."""
    name, scene = make(steep), scene_at(tmp_path, ratio, modulus)
    ic, estimate = read(name, scene)
    error = np.abs(ic - true_c(scene, steep))
    assert np.all(error <= estimate - ESTIMATE)
    assert np.max(error) > 1e-4 * np.max(ic)
    assert np.max(estimate - ESTIMATE) < 100 * np.max(error)


def test_contact_with_a_map_agrees_with_c_within_its_estimate(make, tmp_path):
    name = make(steep)
    scene = scene_at(tmp_path, 1.15, 3e5, contact={"ics": ["Bhat", name, "C"]})
    contacts = compute_contact(scene, given=maps_of_scene(scene)).isel(case=0)
    c, by_map = contacts.sel(ics="C"), contacts.sel(ics=name)
    for number in ("p_max", "approach", "a", "b"):
        assert float(by_map[number]) == pytest.approx(float(c[number]), rel=1e-2)
        assert abs(float(by_map[number] - c[number])) < float(by_map[f"estimate_{number}"])
    assert float(by_map.approach) != float(c.approach)
    assert float(by_map.estimate_approach) > float(c.estimate_approach)
    assert abs(float(contacts.approach.sel(ics="Bhat") / c.approach) - 1) > 0.1


ROLLING = BASE.replace(
    'ics = ["Bhat", "C"] }',
    'ics = ["Bhat", "C"], motion = "rolling", friction = [0.3], longitudinal = [-1e-3, 1e-3], spin = 1e-4 }',
)


def rolling_at(folder, ratio, modulus, ics):
    keys = {"motion": "rolling", "friction": [0.3], "longitudinal": [-1e-3, 1e-3], "spin": 1e-4, "ics": ics}
    return scene_at(folder, ratio, modulus, contact=keys)


def test_with_friction_a_map_has_all_components(make, tmp_path):
    name = make(base=ROLLING)
    scene = rolling_at(tmp_path, 1.15, 3e5, [name])
    given = maps_of_scene(scene)[name]
    assert given.grid == scene.grid
    np.testing.assert_allclose(given.ics, true_c(scene, polynomial), rtol=1e-10, atol=1e-18)
    np.testing.assert_allclose(given.estimate, ESTIMATE, rtol=1e-3)


def test_rolling_with_a_map_agrees_with_c_within_its_estimate(make, tmp_path):
    name = make(steep, base=ROLLING)
    scene = rolling_at(tmp_path, 1.15, 3e5, ["Bhat", name, "C"])
    c = GivenICs(scene.grid, true_c(scene, steep))
    by_ics = compute_with_friction(scene, given=maps_of_scene(scene) | {"C": c}).isel(friction=0, xi=0)
    c, by_map, bhat = (by_ics.sel(ics=ics) for ics in ("C", name, "Bhat"))
    for number in ("F_x", "F_y", "p_max"):
        assert float(by_map[number]) == pytest.approx(float(c[number]), rel=1e-2)
        assert abs(float(by_map[number] - c[number])) < float(by_map[f"estimate_{number}"])
        assert abs(float(bhat[number] - c[number])) > 10 * abs(float(by_map[number] - c[number])) > 0


COMPRESSION = BASE.replace('"C"] }', '"C"], motion = "compression", friction = [0.3] }')


@pytest.mark.parametrize(
    ("own", "other"), [(BASE, ROLLING), (ROLLING, COMPRESSION), (ROLLING, BASE)], ids=["", "rolling", "none"]
)
def test_a_map_serves_its_own_motion_only(make, tmp_path, own, other):
    name = make(base=own)
    (tmp_path / "base.toml").write_text(other, encoding="utf-8")
    scene = scene_at(tmp_path, 1.15, 3e5)
    with pytest.raises(BadScene, match=r"contact\.motion of the lower body: not as in"):
        read(name, scene)


def test_contact_is_solved_on_the_grid_of_the_map(make, tmp_path):
    name = make()
    scene = scene_at(tmp_path, 1.15, 3e5, contact={"ics": ["A", name], "grid": "automatic"})
    ((grid, _),) = grids_of(scene.contact_problem, maps_of_scene(scene))
    assert (grid.n_x, grid.n_s, grid.dx, grid.ds) == (10, 10, 0.7, 0.55)
    small = scene_at(tmp_path, 1.05, 1e5, contact={"ics": [name], "loads": [1e6]})
    with pytest.raises(Failure, match=r"contact at 1e\+06 N with map:"):
        compute_contact(small, given=maps_of_scene(small))


def test_reference_is_c_else_a_map_else_bhat():
    assert reference_name(["A", "map:a", "Bhat", "C"]) == "C"
    assert reference_name(["A", "Bhat", "map:a"]) == "map:a"
    assert reference_name(["A", "Bhat", "mix"]) == "Bhat"
    assert ics_symbol("map:out/flanks/sweep.nc") == "C from flanks"


MODULI = {"lower": {"E": 3e5}, "upper": {"E": 3e5}}


@pytest.mark.parametrize(
    ("body", "changes", "message"),
    [
        ("lower", {"nu": 0.3}, "nu of the lower body: not as in"),
        ("upper", {"rolling_radius": 460.0}, "rolling_radius of the upper body: not as in"),
        ("lower", {"contour": {"kind": "plane"}}, "contour"),
        ("lower", {"E": 4e5}, r"lower\.E, upper\.E give E = .* the same"),
        ("", {"contact": {"shift": 0.1}}, r"contact\.shift"),
        ("", {"rotation_reach": 15.0}, "rotation_reach"),
    ],
)
def test_scenes_outside_the_map_are_refused(make, tmp_path, body, changes, message):
    name = make()
    keys = MODULI | ({body: MODULI[body] | changes} if body else changes)
    with pytest.raises(BadScene, match=message):
        read(name, load_scene(str(tmp_path / "base.toml"), keys))


def test_keys_without_influence_on_c_may_differ(make, tmp_path):
    name = make()
    scene = scene_at(tmp_path, 1.15, 3e5, engine={"tolerance": 0.1}, contact={"loads": [3e3]}, title="other")
    for values, expected in zip(read(name, scene), read(name, scene_at(tmp_path, 1.15, 3e5)), strict=True):
        np.testing.assert_array_equal(values, expected)


def test_extrapolation_is_refused_and_missing_nodes_are_named(make, tmp_path):
    name = make(left_out=(0,))
    with pytest.raises(WrongInput, match=r"ratio = 1\.4: outside the map, 1\.05 \.\.\. 1\.3"):
        read(name, scene_at(tmp_path, 1.4, 3e5))
    with pytest.raises(Failure, match=r"no result at ratio = 1\.05, E = 100000: did not converge"):
        read(name, scene_at(tmp_path, 1.07, 1.5e5))


@pytest.fixture
def copied(make, tmp_path):
    """The file of a copy of the map, and a scene within it."""
    path = tmp_path / "sweep.nc"
    shutil.copy(make().removeprefix("map:"), path)
    return path, scene_at(tmp_path, 1.15, 3e5)


@pytest.mark.parametrize("variable", ["c", "c_estimate", "bhat", "E"])
def test_damaged_map_is_refused(copied, variable):
    path, scene = copied
    read(f"map:{path}", scene)
    with h5py.File(path) as file:
        place = file[variable].id.get_chunk_info(0).byte_offset
    content = bytearray(path.read_bytes())
    content[place] ^= 1
    path.write_bytes(content)
    kind, message = Failure, r"sweep\.nc: damaged \(.*\): run the campaign again"
    if variable == "E":  # axes are read when the file is opened
        kind, message = BadScene, r"sweep\.nc: not the file of a campaign: .*read data"
    with pytest.raises(kind, match=message):
        read(f"map:{path}", scene)


def test_half_written_scene_is_not_read(copied):
    path, scene = copied
    with h5py.File(path, "a") as file:
        file["digest"][1, 2] = 0
    with pytest.raises(Failure, match=r"no result at ratio = 1.1, E = 400000: not computed yet"):
        read(f"map:{path}", scene)


def test_large_map_with_an_unreadable_chunk_is_refused(make, tmp_path, monkeypatch):
    make()
    monkeypatch.setattr("compare.campaigns.dataset.LARGEST_FILE", 1)
    path = write_map(tmp_path, (), BASE, CAMPAIGN)
    chunk = next(file for file in (path / "c" / "c").rglob("*") if file.is_file())
    chunk.write_bytes(chunk.read_bytes()[:-9])
    with pytest.raises(Failure, match=r"sweep\.zarr: damaged .*: run the campaign again"):
        read(f"map:{path}", scene_at(tmp_path, 1.15, 3e5))


def test_other_files_are_refused(make, tmp_path):
    for name, message in (
        ("map:nowhere.nc", "no such file"),
        (f"map:{__file__}", "not the file of a campaign"),
    ):
        with pytest.raises(BadScene, match=message):
            open_map(name, None)
    xr.Dataset(attrs={"points": "grid"}).to_netcdf(tmp_path / "other.nc", engine="h5netcdf")
    with pytest.raises(BadScene, match="not a map"):
        open_map(f"map:{tmp_path / 'other.nc'}", None)
    few = CAMPAIGN.replace("1.05, 1.1, 1.2, 1.3", "1.05, 1.1")
    with pytest.raises(BadScene, match=r"axis ratio, 2 values: a map needs 3 or more"):
        open_map(make(campaign=few), None)
