"""`femic matrix` and `femic plan`: files, messages, what is solved and what is not."""

import json
import re
import shutil
from contextlib import ExitStack, contextmanager

import h5py
import numpy as np
import pytest
import xarray as xr

from compare.pages import matrix as page
from compare.pages.matrix import PER_KILONEWTON, chart, response
from femic.cache.store import Store
from femic.cli.main import DONE, FAILED, INTERRUPTED, WRONG_INPUT, exit_code
from femic.reference.engines import SOLID
from femic.reference.harmonic import engine as harmonic
from femic.reference.harmonic.section_response import Condensation
from femic.reference.refinement import Assessment
from femic.reference.run_options import Level, RunOptions
from femic.reference.solid import engine as solid
from femic.results.contact_file import read
from femic.results.export import SUFFIXES
from femic.results.ics import jobs
from femic.results.matrices import (
    FIRST_SECONDS,
    MatrixFile,
    combined_columns,
    compute_matrix,
    expected_seconds,
    file_size,
    matrix_jobs,
    matrix_plans,
)
from femic.results.matrix_check import ColumnCheck, check_columns, checked_strips
from femic.scenes.errors import BadScene
from femic.scenes.load import load_scene, scene_from_table
from geometries.errors import Failure
from geometries.patches import COMPONENTS, DIRECTIONS
from tests.coarse import coarse_sections
from tests.compare.conftest import FINER_ENGINE, scene_text
from tests.compare.pages import read_chart, require_room

GRID = "\n[grid]\nn_x = 5\nn_s = 4\n"
HARMONIC = "[engine]\ntolerance = 0.5\n"
WIDER = "a = 0.3\nb = 0.2", "a = 1.0\nb = 1.0"  # a patch on which fewer wavenumbers do


@pytest.fixture(scope="module", autouse=True)
def _coarse():
    """How accurate C is does not matter here."""
    with coarse_sections():
        yield


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """A scene of two bodies of different stiffness, its matrix and the folder it was written to."""
    folder = tmp_path_factory.mktemp("matrix")
    path = folder / "mine.toml"
    path.write_text(scene_text(engine=HARMONIC + GRID, upper_E=70e3), encoding="utf-8")
    out = folder / "out"
    assert exit_code(["matrix", str(path), "--out", str(out), "--workers", "2"]) == DONE
    return path, out


def test_file_contains_ics_estimates_and_attributes(made):
    _, out = made
    with xr.open_dataset(out / "matrix.nc", engine="h5netcdf") as file:
        assert file.ic.dims == ("body", "lag", "observed", "loaded", "i", "j")
        assert file.ic.shape == (3, 5, 4, 4, 3, 3)
        np.testing.assert_allclose(file.lag, 0.6 * np.arange(5))
        np.testing.assert_allclose(file.loaded, 0.4 * (np.arange(4) - 1.5))
        both = file.ic.sel(body="upper") + file.ic.sel(body="lower")
        np.testing.assert_allclose(file.ic.sel(body="combined"), both, rtol=1e-12, atol=1e-18)
        share = (file.estimate / file.ic.sel(i="n", j="n")).max()
        assert 0 < share < 0.1
        assert file.ic.isel(lag=0, observed=1, loaded=1).sel(i="n", j="n").min() > 0
        # softer by three: E of the upper body is a third of the lower's
        ratio = file.ic.sel(body="upper", i="n", j="n") / file.ic.sel(body="lower", i="n", j="n")
        assert float(ratio.isel(lag=0, observed=1, loaded=1)) == pytest.approx(3.0, rel=0.02)
        eigenvalues = json.loads(file.attrs["smallest_eigenvalue"])
        assert set(eigenvalues) > {"lower, raw", "upper, raw", "combined, discounted"}
        assert min(eigenvalues.values()) > 0
        assert json.loads(file.attrs["models"])["lower, fine"]["unknowns"] > 1000
        assert file.ic.attrs["units"] == file.estimate.attrs["units"] == "mm/MPa"


def test_report_shows_maps(made):
    html = (made[1] / "matrix.html").read_text(encoding="utf-8")
    charts = re.findall(r'id="chart-(\w+)"', html)
    assert charts == ["response", "maps"]
    assert "expected / actual" in html


@pytest.fixture(scope="module")
def solved(made):
    """Its scene, and C of its bodies, from what is stored: nothing is meshed or factored."""
    path, out = made
    scene = load_scene(str(path))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(harmonic, "build_section", lambda *_: pytest.fail("a mesh was made"))
        patch.setattr(Condensation, "respond", lambda *_: pytest.fail("a matrix was factored"))
        return scene, compute_matrix(scene, out / "again.nc", RunOptions(store=Store(out / "store")))


@pytest.fixture(scope="module")
def matrix(made):
    with xr.open_dataset(made[1] / "matrix.nc", engine="h5netcdf") as file:
        yield file


def by_body(file, attribute):
    """The numbers of an attribute by matrix."""
    return json.loads(file.attrs[attribute])


@contextmanager
def opened(*paths):
    """Files of matrices."""
    with ExitStack() as stack:
        yield [stack.enter_context(xr.open_dataset(path, engine="h5netcdf")) for path in paths]


def test_answer_and_summary_have_the_numbers_of_each_matrix(matrix):
    estimates, defects = (by_body(matrix, name) for name in ("estimated_error", "reciprocity_defect"))
    eigenvalues = by_body(matrix, "smallest_eigenvalue")
    body, worst = max(estimates.items(), key=lambda item: item[1]["total"])
    text = page.summary(matrix, "matrix.nc (0.1 MB)", 0.5)
    assert text.startswith("matrix.nc (0.1 MB) holds C for 4 strips and 5 lags. C is converged: its largest ")
    assert f"error is {100 * worst['total']:.2f} % ({worst['component']}, {body}), the tolerance" in text
    checks = [ColumnCheck("lower", strip, 0.002, "xn", 0.005, 0.3 + strip / 10, 9.0) for strip in (0, 1)]
    answer = page.answer_table(matrix, checks, 0.5)
    assert [row.name for row in answer.rows] == ["combined", "lower", "upper"]
    for row in answer.rows:
        estimate, defect, eigenvalue, check = (cell.text for cell in row.filled)
        shares = estimates[row.name]
        assert estimate == f"{100 * shares['total']:.2g} ({shares['component']})"
        if row.name == "combined":
            assert defect == "–"
        else:
            assert float(defect.split()[0]) == pytest.approx(100 * defects[row.name]["worst"], rel=0.05)
        assert float(eigenvalue) == pytest.approx(eigenvalues[f"{row.name}, discounted"], abs=0.005)
        assert check == ("0.40" if row.name == "lower" else "–")
    assert len(page.answer_table(matrix, [], 0.5).heads) == 3


@pytest.mark.parametrize(("share", "is_within"), [(1.01, True), (0.99, False)])
def test_c_above_the_tolerance_is_a_doubt(matrix, share, is_within):
    worst = max(one["total"] for one in by_body(matrix, "estimated_error").values())
    doubts = list(page.doubts(matrix, [], share * worst))
    assert (doubts == []) == is_within
    assert ("C is converged" in page.summary(matrix, "", share * worst)) == is_within
    below = {cell.below for row in page.answer_table(matrix, [], share * worst).rows for cell in row.filled}
    assert ("within the tolerance: no" in below) != is_within


def test_negative_work_and_engines_apart_are_doubts(matrix):
    eigenvalues = by_body(matrix, "smallest_eigenvalue") | {"lower, raw": -0.2}
    negative = matrix.assign_attrs(smallest_eigenvalue=json.dumps(eigenvalues))
    checks = [ColumnCheck("upper", 1, 0.02, "xn", 0.01, ratio, 9.0) for ratio in (0.9, 2.0)]
    work, apart = page.doubts(negative, checks, 1.0)
    assert "lower, raw" in work
    assert apart.startswith("upper, strip 1: the solid engine differs from C by 2 times")


def test_maps_are_the_matrix_of_the_file(solved, matrix, made):
    content = read_chart(page.maps(response(solved[0], matrix, solved[1], 2)))
    assert content["labels"] == list(COMPONENTS)
    with xr.open_dataset(made[1] / "matrix.nc", engine="h5netcdf") as file:
        per_load = PER_KILONEWTON * file.isel(loaded=2) / (file.attrs["dx"] * file.attrs["ds"])
        for component in ("nn", "sn"):
            ic = per_load.ic.sel(body="combined", i=component[0], j=component[1])
            cells = content["steps"][content["labels"].index(component)]
            shown = next(cell for cell in cells if cell["title"] == "C")["traces"][0]
            np.testing.assert_allclose(
                shown["customdata"], ic.T, rtol=0, atol=1e-3 * float(np.ptp(ic.values))
            )
            np.testing.assert_allclose(shown["x"], file.lag, rtol=1e-5)
            np.testing.assert_allclose(shown["y"], file.observed, rtol=1e-5)


@pytest.mark.parametrize("component", ["nn", "xn", "sn"])
def test_differences_are_those_of_curves_from_c_after_the_discount_of_the_source(solved, matrix, component):
    """By another route: the ICs of the scene's bodies, and columns of both bodies."""
    strip = 2
    i, j = ("xsn".index(name) for name in component)
    scene, references = solved
    c = sum(references[body].column(strip, "source").ic[i, j] for body in ("lower", "upper"))
    grid, pair = scene.grid, scene.pair
    a = pair.approximate("A", grid.patch(strip), (grid.lags[:, None], grid.strips))[i, j] / grid.area
    content = read_chart(chart(response(scene, matrix, references, strip)))
    cells = content["steps"][content["labels"].index(component)]
    for number, at in ((0, np.s_[0, :]), (2, np.s_[:, strip])):
        curves, differences = (
            {trace["name"]: trace["y"] for trace in cells[number + k]["traces"] if "name" in trace}
            for k in (0, 1)
        )
        tolerance = {"rtol": 2e-5, "atol": 1e-8 * np.max(np.abs(PER_KILONEWTON * c))}
        np.testing.assert_allclose(curves["C"], PER_KILONEWTON * c[at], **tolerance)
        np.testing.assert_allclose(differences["A"], PER_KILONEWTON * (a - c)[at], **tolerance)
        assert not np.any(differences["C"])


@pytest.mark.slow
def test_page_is_not_wider_than_the_window(made, browser):
    require_room(browser, made[1] / "matrix.html", {1280: 1150, 800: 770, 400: 1150})


@pytest.mark.usefixtures("solved")
def test_second_run_meshes_and_factors_nothing(made, capsys):
    path, out = made
    with opened(out / "matrix.nc", out / "again.nc") as (first, second):
        xr.testing.assert_equal(first, second)
    assert exit_code(["matrix", str(path), "--out", str(out)]) == DONE
    assert "already in the folder" in capsys.readouterr().out
    assert exit_code(["matrix", str(path), "--out", str(out), "--figures", "svg"]) == DONE
    assert list((out / "figures").glob("matrix_*.svg"))


def test_maps_of_another_strip_need_no_new_models(made, monkeypatch):
    path, out = made
    before = (out / "matrix.html").read_text(encoding="utf-8")
    monkeypatch.setattr(Condensation, "respond", lambda *_: pytest.fail("a matrix was factored"))
    assert exit_code(["matrix", str(path), "--out", str(out), "--strip", "0"]) == DONE
    after = (out / "matrix.html").read_text(encoding="utf-8")
    assert ["on an element of strip 0" in text for text in (before, after)] == [False, True]
    assert exit_code(["matrix", str(path), "--out", str(out), "--strip", "4"]) == WRONG_INPUT


def test_large_matrices_are_not_held_as_a_whole_and_made_in_threads(made, monkeypatch):
    path, out = made
    monkeypatch.setattr("femic.reference.matrix.reference.ELEMENTS_FOR_THREADS", 1)
    monkeypatch.setattr("femic.results.matrices.LARGEST_WHOLE_MATRIX", 100)
    monkeypatch.setattr("femic.reference.matrix.reference.REMEMBERED_ENTRIES", 100)
    compute_matrix(load_scene(str(path)), out / "large.nc", RunOptions(2, Store(out / "store")))
    with opened(out / "matrix.nc", out / "large.nc") as (first, second):
        xr.testing.assert_equal(first, second)
        assert not by_body(second, "smallest_eigenvalue")
        assert not by_body(second, "reciprocity_defect")


def test_file_of_a_round_that_was_not_accurate_enough_is_written_anew(made, monkeypatch, tmp_path):
    path, out = made
    rounds, begin = [], MatrixFile.begin

    def begun(file, references):
        rounds.append({body: reference.level for body, reference in references.items()})
        begin(file, references)

    def refined(*_):
        return {} if len(rounds) > 1 else {"lower": Level(cells=1)}

    monkeypatch.setattr(MatrixFile, "begin", begun)
    monkeypatch.setattr(Assessment, "meets", lambda *_: len(rounds) > 1)
    monkeypatch.setattr("femic.reference.refinement.next_levels", refined)
    scene, file = load_scene(str(path), {"bodies": ["lower"]}), tmp_path / "matrix.nc"
    store = Store(shutil.copytree(out / "store", tmp_path / "store"))
    references = compute_matrix(scene, file, RunOptions(2, store))
    assert [one["lower"] for one in rounds] == [Level(), Level(cells=1)]
    with opened(file, out / "matrix.nc") as both:
        written, coarser = (one.sel(body="lower") for one in both)
        for strip in range(scene.grid.n_s):
            column = combined_columns(scene, references, strip)["lower"].ic
            found = written.ic[:, :, strip].transpose("i", "j", "lag", "observed")
            np.testing.assert_allclose(found, scene.grid.area * column, rtol=1e-12, atol=0)
        assert not np.allclose(written.ic, coarser.ic, rtol=1e-9, atol=0)


def test_grid_beyond_measured_contour_is_refused_only_by_matrix():
    y = np.linspace(-4, 4, 21)
    contour = {"kind": "points", "points": np.column_stack([y, -(y**2) / 20]).tolist()}
    body = {"E": 210e3, "nu": 0.3, "contour": contour}
    table = {"lower": body, "upper": body, "patch": {"a": 0.2, "b": 0.2}, "lines": [{"along": "x", "s": 1.0}]}
    scene = scene_from_table(table, "short")
    with pytest.raises(BadScene, match=r"32 strips of 0\.4 mm go from s = -6\.4 to 6\.4 mm, the contours"):
        matrix_jobs(scene)
    with pytest.raises(BadScene, match="give fewer"):
        scene_from_table(table | {"grid": {"n_s": 40}}, "short")


@pytest.mark.slow
@pytest.mark.usefixtures("as_tuned")
def test_interrupted_matrix_continues_where_it_stopped(write_scene, tmp_path, monkeypatch):
    engine = "[engine]\ntolerance = 0.5\n[grid]\nn_x = 2\nn_s = 2\n"
    path, out = write_scene('bodies = ["lower"]', engine=engine), tmp_path / "o"
    path.write_text(path.read_text(encoding="utf-8").replace(*WIDER), encoding="utf-8")
    solved, solve = [], Condensation.respond

    def counted(self, k, supports):
        if len(solved) >= 25 and not interrupted:
            interrupted.extend(k)
            raise KeyboardInterrupt
        solved.extend((self.forces.shape, one) for one in k)  # coarser cells at some of them, too
        return solve(self, k, supports)

    interrupted = []
    monkeypatch.setattr(Condensation, "respond", counted)
    command = ["matrix", str(path), "--out", str(out), "--workers", "1"]
    assert exit_code(command) == INTERRUPTED
    assert not (out / "matrix.nc").exists()
    assert exit_code(command) == DONE
    assert len(set(solved)) == len(solved) > 25


def test_changed_results_are_computed_again(made, tmp_path, monkeypatch, capsys):
    path, out = made
    folder = shutil.copytree(out, tmp_path / "o", ignore=shutil.ignore_patterns("store"))
    (folder / "matrix.html").write_text("changed", encoding="utf-8")

    def begun(*_):
        raise Failure("it is made")

    monkeypatch.setattr(page, "compute_matrix", begun)
    assert exit_code(["matrix", str(path), "--out", str(folder), "--store", str(out / "store")]) == FAILED
    assert "it is made" in capsys.readouterr().err
    assert not (folder / "matrix.receipt.json").exists()


def test_damaged_chunk_of_matrix_is_not_read(made, tmp_path):
    _, out = made
    with h5py.File(out / "matrix.nc", "r") as file:
        chunk = file["ic"].id.get_chunk_info(0)
    content = bytearray((out / "matrix.nc").read_bytes())
    content[chunk.byte_offset + chunk.size // 2] ^= 1
    (tmp_path / "matrix.nc").write_bytes(content)
    with (
        xr.open_dataset(tmp_path / "matrix.nc", engine="h5netcdf") as damaged,
        pytest.raises(OSError, match="filter"),
    ):
        damaged.ic.load()


# --- plan ------------------------------------------------------------------------------------------------


def test_plan_solves_nothing_and_names_every_model(write_scene, monkeypatch, capsys):
    for module, name in ((harmonic, "SectionSolver"), (solid, "assemble")):
        monkeypatch.setattr(module, name, lambda *_: pytest.fail("something was assembled"))
    path = write_scene(engine=HARMONIC + GRID + "\n")
    assert exit_code(["plan", str(path)]) == DONE
    text = capsys.readouterr().out
    for name in ("lower, fine", "upper, fine"):
        assert text.count(name) == 2, name  # of the run and of the matrix
    assert "5 lags of 0.6 mm" in text


def test_plan_predicts_unknowns_wavenumbers_and_file_size(made):
    path, out = made
    scene = load_scene(str(path))
    with xr.open_dataset(out / "matrix.nc", engine="h5netcdf") as file:
        costs = json.loads(file.attrs["models"])
    for step in matrix_plans(scene, 2):
        assert step.expected.unknowns == costs[step.name]["unknowns"]
        wavenumbers = int(costs[step.name]["solver"].split(", ")[-1].split()[0])
        assert wavenumbers / 2 < step.expected.wavenumbers < 2 * wavenumbers
    planned_size = file_size(scene)
    assert planned_size < (out / "matrix.nc").stat().st_size < planned_size + 100_000


def test_seconds_of_matrices_grow_with_their_entries():
    """They are n_x n_s^2 times nine for each body, and for the sum."""

    def seconds(n_s, n_x, **compared):
        scene = load_scene("geometry2", {"grid": {"n_s": n_s, "n_x": n_x}, **compared})
        return expected_seconds(scene) - FIRST_SECONDS

    small = seconds(32, 64)
    assert seconds(32, 128) == pytest.approx(2 * small)
    assert seconds(64, 64) == pytest.approx(4 * small)
    assert seconds(32, 64, bodies=["lower"]) == pytest.approx(small / 3)


def test_plan_of_solid_engine_is_right_to_factor_of_two(write_scene):
    scene = load_scene(str(write_scene('bodies = ["lower"]', engine=FINER_ENGINE)))
    request = jobs(scene)["lower"].request(Level())
    cells = solid.build_mesh(request)
    assert 0.5 < SOLID.expected_cost(request, 2).unknowns / (3 * cells.nodes.shape[1]) < 2


# --- the solid engine --------------------------------------------------------------------------------


def test_checked_strips_are_spread_over_grid(made):
    path, _ = made
    for count, strips in ((0, []), (1, [2]), (2, [0, 3]), (3, [0, 2, 3])):
        assert checked_strips(load_scene(str(path), {"grid": {"check": count}})) == strips


@pytest.mark.slow
@pytest.mark.usefixtures("as_tuned")
def test_column_computed_with_solid_engine_agrees_within_estimates(made, tmp_path):
    path, _ = made
    scene = load_scene(str(path), {"bodies": ["lower"], "grid": {"check": 1, "n_x": 8}})
    solved = compute_matrix(scene, tmp_path / "matrix.nc", RunOptions(2))
    (column,) = check_columns(scene, solved, RunOptions(2, Store(tmp_path / "store")))
    assert (column.body, column.strip) == ("lower", 2)
    assert column.component in {i + j for i in DIRECTIONS for j in DIRECTIONS}
    assert column.closest <= 1.0
    assert column.difference < 5e-3


def test_export_is_matrix_times_combined_shear_modulus(made):
    path, out = made
    assert exit_code(["export", str(path), "--out", str(out)]) == DONE
    file, scene = read(out / "contact_C.txt"), load_scene(str(path))
    assert (file.n_x, file.n_s, len(file.values), file.convex) == (5, 4, 4, 2)
    with xr.open_dataset(out / "matrix.nc", engine="h5netcdf") as dataset:
        both = dataset.ic.sel(body="combined").values
    for loaded, observed in np.ndindex(4, 4):
        expected = scene.pair.constants.G * both[:, observed, loaded]
        np.testing.assert_array_equal(file.values[loaded, observed - loaded + 3], expected)


@pytest.mark.parametrize("discount", ["approach", "source"])
def test_a_far_arc_that_the_scene_gives_is_that_of_its_matrices_with_any_discount(discount):
    """By default the one of the source's discount grows with the grid, and stands for a body without end."""
    jobs = {
        far_radius: matrix_jobs(load_scene("flat", {"discount": discount, "engine": keys}))["lower"]
        for far_radius, keys in ((60.0, {"far_radius": 60.0}), (None, {}))
    }
    given, default = jobs[60.0], jobs[None]
    assert given.request(Level(domain=1)).body.domain.far_radius == 60.0
    assert given.given_domain
    assert default.given_domain == (discount == "approach")


@pytest.mark.parametrize(("discount", "rank"), [("approach", 1), ("source", 4)])
def test_raw_c_differs_from_c_by_one_rigid_motion_of_each_body(made, capsys, discount, rank):
    """The same at all lags, as bodies are prismatic; symmetric; of rank 4: three forces and a moment.

    The approach is one force. Both contours are alike, so their rigid parts have the same wrenches.
    """
    path, out = made
    command = ["export", str(path), "--out", str(out), "--discount"]
    assert exit_code([*command, discount]) == exit_code([*command, "none"]) == DONE
    output = " ".join(capsys.readouterr().out.split())
    assert (
        "contact_C_raw.txt: 4 matrices, one per loaded strip, 5 lags; raw: with the rigid compliance"
        in output
    )
    ruled, raw = (read(out / f"contact_C{name}.txt") for name in (SUFFIXES[discount], "_raw"))
    assert raw.values.shape == ruled.values.shape == (4, 7, 5, 3, 3)
    taken = raw.values - ruled.values
    for loaded, observed in np.ndindex(4, 4):
        of_lags = taken[loaded, observed - loaded + 3]
        np.testing.assert_allclose(of_lags, np.broadcast_to(of_lags[0], of_lags.shape), atol=1e-9)
    pairs = np.array([[taken[m, o - m + 3, 0] for m in range(4)] for o in range(4)])  # (o, m, i, j)
    rigid = pairs.transpose(0, 2, 1, 3).reshape(12, 12)
    np.testing.assert_allclose(rigid, rigid.T, atol=1e-9)
    sizes = np.linalg.svd(rigid, compute_uv=False)
    assert sizes[rank - 1] > 1e-6 * sizes[0] > 1e3 * sizes[rank]
    assert np.max(np.abs(taken)) > 1e-4 * np.max(ruled.values)
