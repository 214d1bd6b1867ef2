"""`femic calibrate`, `calibrate-map`: what is fitted to what, files, scenes with the fit, messages."""

import re
import tomllib
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

from approx.calibration import fit
from approx.effective import EffectiveProperties, Transition
from compare.pages.calibration import (
    REFITTED,
    WITHOUT,
    answer_table,
    doubts,
    fits,
    ics_with_other_c,
    other_c,
    summary,
    translation,
    verdict,
)
from compare.report.errors import percent
from femic.cache.store import Store
from femic.cli.main import DONE, WRONG_INPUT, exit_code
from femic.reference.harmonic import engine as harmonic
from femic.reference.run_options import RunOptions
from femic.reference.solid import engine as solid
from femic.results.calibration import calibrate, target_from, with_properties
from femic.results.ics import compute, reference_ics
from femic.scenes.load import load_scene, scene_from_table
from tests.coarse import coarse_sections
from tests.compare.conftest import scene_text
from tests.compare.pages import read_chart, read_traces, require_room

CALIBRATION = "\n[calibration]\npoints = 40\nx_max = 12.0\n"
HARMONIC = "[engine]\nfar_radius = 80.0\ntolerance = 0.5\ncheck = true\n" + CALIBRATION


@pytest.fixture(scope="module", autouse=True)
def _coarse():
    """How accurate C is does not matter here."""
    with coarse_sections():
        yield


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """A scene of two unlike bodies, calibrated from the command line: its path and the folder of results."""
    folder = tmp_path_factory.mktemp("calibration")
    path = folder / "mine.toml"
    path.write_text(scene_text(engine=HARMONIC, upper_E=70e3), encoding="utf-8")
    out = folder / "out"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(solid, "assemble", lambda _: pytest.fail("a 3D model, which no fit needs"))
        assert exit_code(["calibrate", str(path), "--out", str(out), "--workers", "2"]) == DONE
    return path, out


@pytest.fixture(scope="module")
def calibrated(made):
    path, out = made
    return calibrate(load_scene(str(path)), RunOptions(store=Store(out / "store")))


def test_file_contains_fit_points_weights_covariance_and_residuals(made, calibrated):
    _, out = made
    with xr.open_dataset(out / "calibration.nc", engine="h5netcdf") as dataset:
        assert dataset.sizes == {"body": 1, "parameter": 4, "parameter_": 4, "component": 1, "point": 80}
        assert list(dataset.parameter.values) == [f"mismatch_k.{p}" for p in ("far", "r_inf", "m", "n")]
        assert set(dataset.s.values) == {0.0, 1.6}
        np.testing.assert_allclose([dataset.x.min(), dataset.x.max()], [0.6 + 11.4 / 40, 12.0])
        np.testing.assert_array_equal(dataset.weight, 1.0)
        off = abs(dataset.fitted - dataset.c).sel(body="combined", component="xn") / abs(dataset.c).max()
        np.testing.assert_allclose(dataset.worst.item(), off.max(), rtol=1e-9)
        np.testing.assert_allclose(dataset.rms.item(), np.sqrt((off**2).mean()), rtol=1e-9)
        fitted = ~np.isnan(np.diag(dataset.covariance[0]))
        deviations = [parameter.deviation for parameter in calibrated.fits["combined"].parameters]
        np.testing.assert_array_equal(fitted, [deviation is not None for deviation in deviations])
        variances = np.diag(dataset.covariance[0])[fitted]
        np.testing.assert_allclose(np.sqrt(variances), [d for d in deviations if d is not None])


def test_fitted_c_equals_c_of_scene(calibrated, made):
    path, out = made
    target = calibrated.targets["combined"]
    assert np.sum(target.s == 1.6) == 40
    fitted, c = c_of_fit_and_scene(target, path, ["nn", "xn"], RunOptions(store=Store(out / "store")))
    assert np.max(np.abs(fitted - c)) < 0.005 * np.max(np.abs(c))


def c_of_fit_and_scene(target, path, components, options):
    """C_xn of a fit at its points on the line s = 1.6 mm, and C_xn of the scene there."""
    line = [{"along": "x", "s": 1.6, "reach": 12.0, "points": 201}]
    scene = load_scene(str(path), {"lines": line, "components": components, "engine": {"check": False}})
    results = compute(scene, options)
    c = reference_ics(results, "combined").ic[0, 2] * scene.patch.area
    on_line = target.s == 1.6
    return target.ics[0, on_line], np.interp(target.x[on_line], results.points.x, c)


@pytest.mark.slow
@pytest.mark.usefixtures("as_tuned")
@pytest.mark.parametrize("components", [["xn"], ["nn", "xn", "xx"]])
def test_fitted_c_of_wheel_equals_c_of_scene_with_any_components(tmp_path, components):
    text = scene_text(engine=HARMONIC, upper_E=70e3).replace("[upper]", "[upper]\nrolling_radius = 60.0")
    path = tmp_path / "wheel.toml"
    path.write_text(text, encoding="utf-8")
    target = calibrate(load_scene(str(path)), RunOptions(1)).targets["combined"]
    fitted, c = c_of_fit_and_scene(target, path, components, RunOptions(1))
    assert np.max(np.abs(fitted - c)) < 0.005 * np.max(np.abs(c))


def test_written_scene_reproduces_fitted_b_hat_prime(made, calibrated):
    _, out = made
    scene = load_scene(str(out / "mine_calibrated.toml"))
    assert scene.variants[-1] == "Bhat_prime"
    target, fitted = calibrated.targets["combined"], calibrated.fits["combined"]
    points = target.x, target.s
    got = scene.pair.approximate("Bhat_prime", scene.patch, points)[0, 2]
    expected = target.bhat_prime(fitted.effective)[0]
    np.testing.assert_allclose(got, expected, atol=1e-4 * np.max(np.abs(expected)))
    mix = scene.pair.approximate("mix", scene.patch, points)[0, 2]
    np.testing.assert_array_equal(mix, got)


def test_report_shows_fit(made):
    _, out = made
    html = (out / "calibration.html").read_text(encoding="utf-8")
    assert {"fits", "other_c"} < set(re.findall(r'id="chart-(\w+)"', html))
    assert "mismatch_k.far" in html
    assert "[effective.combined]" in html


def test_fit_is_closer_to_c_than_no_fit_and_neighbouring_parameters(calibrated):
    """Least squares: no transition, and each neighbour, is worse."""
    target, best = calibrated.targets["combined"], calibrated.fits["combined"].effective

    def cost(effective):
        return np.sum((target.bhat_prime(effective) - target.ics) ** 2)

    transition = best.mismatch_k
    half_space = target.solid.constants.mismatch_k
    assert cost(best) < 0.5 * cost(EffectiveProperties(mismatch_k=replace(transition, far=half_space)))
    for factor in (0.95, 1.05):
        other = replace(transition, far=factor * transition.far)
        assert cost(best) < cost(EffectiveProperties(mismatch_k=other))


def test_second_calibration_solves_nothing(made, monkeypatch, calibrated):
    path, out = made
    monkeypatch.setattr(harmonic, "build_section", lambda *_: pytest.fail("a mesh was made"))
    other = load_scene(str(path), {"calibration": {"weights": "logarithmic"}})
    weighted = calibrate(other, RunOptions(store=Store(out / "store")))
    target = weighted.targets["combined"]
    np.testing.assert_allclose(target.weights**2 * target.r, np.min(target.r))
    assert len(target.x) == 80
    assert weighted.fits["combined"].effective != calibrated.fits["combined"].effective


def test_translation_is_least_squares_solution(calibrated):
    ics = calibrated.ics
    lean = -np.sin(calibrated.scene.bodies["lower"].contour.inclination(ics.s.values))
    sn = ics.ic.sel(body="combined", i="s", j="n")
    lack = (sn.sel(variant="Bhat_prime") - sn.sel(variant="C")).values
    moved = translation(calibrated)
    assert abs(lean @ (lack - moved * lean)) < 1e-12 * np.abs(lean) @ np.abs(lack)


def test_summary_has_the_errors_without_and_with_the_fit(calibrated):
    errors = calibrated.errors.error.sel(body="combined", i="x", j="n")
    before, after, known = (percent(errors.sel(variant=one).item()) for one in ("Bhat", "Bhat_prime", "C"))
    change = f"combined C_xn: {before} with B̂, {after} with B̂′, ± {known} (better)"
    said = "Largest errors on the lines of the scene, ± the estimated error of C: "
    assert summary([calibrated]).startswith(f"{said}mine, {change}. ")
    assert f"{said}mine, {change}; other, {change}. " in summary([calibrated, renamed(calibrated)])


@pytest.mark.parametrize(
    ("after", "expected"), [(0.02, "better"), (0.08, "worse"), (0.045, "not decided"), (0.05, "the same")]
)
def test_fit_is_better_only_by_more_than_the_estimate(after, expected):
    assert verdict(0.05, after, 0.01) == expected


def test_components_that_the_fit_makes_worse_are_doubts(calibrated):
    errors = calibrated.errors.copy(deep=True)
    at = {"variant": "Bhat_prime", "body": "combined", "i": "n", "j": "n"}
    errors.error.loc[at] = errors.error.sel(at | {"variant": "Bhat"}).item() + 1.0
    (worse,) = (text for text in doubts([replace(calibrated, errors=errors)]) if "worse" in text)
    assert worse.startswith("mine, combined: B̂′ is worse than B̂ in ")
    assert "nn" in worse


def renamed(calibrated):
    return replace(calibrated, scene=replace(calibrated.scene, name="other"))


def test_answer_has_the_fit_and_the_errors_without_and_with_it(calibrated):
    one, body_fit = calibrated, calibrated.fits["combined"]
    answer = answer_table([one])
    (row,) = answer.rows
    assert row.name == "combined, K [-]"
    assert [head.title for head in answer.heads[3:]] == [f"{c}: B̂ → B̂′ [%]" for c in ("xn", "nn", "sn")]
    far, r_inf, residual, *changes = (cell.text for cell in row.filled)
    values = {parameter.name: parameter for parameter in body_fit.parameters}
    for text, name in ((far, "far"), (r_inf, "r_inf")):
        parameter = values[f"mismatch_k.{name}"]
        if parameter.deviation is None:
            assert text == f"{parameter.value:.5g} (fixed)"
        else:
            assert float(text.split()[0]) == pytest.approx(parameter.value, abs=parameter.deviation)
    assert float(residual) == pytest.approx(100 * np.max(body_fit.rms), rel=0.05)
    for i, text in zip("xns", changes, strict=True):
        at = one.errors.error.sel(body="combined", i=i, j="n")
        shown = [float(error) for error in text.removesuffix(" †").split(" → ")]
        expected = [100 * at.sel(variant=name).item() for name in ("Bhat", "Bhat_prime")]
        assert shown == pytest.approx(expected, rel=6e-3)
    two = answer_table([one, renamed(one)])
    assert [row.name for row in two.rows] == ["mine, combined, K [-]", "other, combined, K [-]"]


def test_chart_has_the_fit_the_k_of_points_and_what_is_left_of_c(calibrated):
    """With its K, a point has its C; what is left at the points is the fitted minus the given ICs."""
    target, fitted = calibrated.targets["combined"], calibrated.fits["combined"].effective
    property_panel, residual = read_chart(fits([calibrated]))["steps"][0]
    drawn = read_traces(property_panel)
    of_fit, half_space = drawn["fit, mine"], target.solid.constants.mismatch_k
    expected = fitted.mismatch_k.at(np.array(of_fit["x"]), half_space)
    np.testing.assert_allclose(of_fit["y"], expected, rtol=1e-4, atol=1e-6)
    marks = drawn["K at s = 1.6 mm"]
    for r, k in list(zip(marks["x"], marks["y"], strict=True))[::5]:
        point = int(np.argmin(np.abs(target.r - r) + 1e3 * (target.s != 1.6)))
        with_k = EffectiveProperties(mismatch_k=Transition(k, 1e-3, 1.0, 1.0))
        got = target.bhat_prime(with_k)[0, point]
        assert got == pytest.approx(target.ics[0, point], rel=1e-3, abs=1e-4 * target.scales.item())
    lines = [trace for trace in residual["traces"] if trace.get("name") == "B̂′"]
    left = 100 * (target.bhat_prime(fitted) - target.ics)[0] / target.scales.item()
    np.testing.assert_allclose(np.concatenate([line["y"] for line in lines]), left, rtol=1e-4, atol=1e-5)
    np.testing.assert_allclose(np.concatenate([line["x"] for line in lines]), target.r, rtol=1e-5)


def test_chart_of_other_c_has_c_beside_it(calibrated):
    panels = other_c([calibrated]).cells
    labels = [[curve.label for curve in panel.curves] for panel in panels]
    lines = calibrated.scene.lines
    assert labels == [[WITHOUT, "B̂′", "C"]] * len(lines) + [[REFITTED, "B", "B̂", "B̂′", "C"]] * len(lines)
    part = calibrated.ics.isel(point=np.flatnonzero(calibrated.ics.line.values == lines[0].name))
    c = 1e6 * part.ic.sel(variant="C", body="combined", i="x", j="n").values
    drawn = panels[0].curves[2].y
    np.testing.assert_allclose(drawn, c[-len(drawn) :])


@pytest.mark.slow
def test_page_is_not_wider_than_the_window(made, browser):
    require_room(browser, made[1] / "calibration.html", {1280: 1150, 800: 770, 400: 1150})


def test_refitted_translation_and_removed_curvature_have_right_sign(calibrated):
    """The refitted translation brings C_sn closer to B-hat-prime; without wheels there is no curvature."""
    sn, xn = (curves(calibrated, i) for i in "sx")
    c, refitted, b_hat_prime = (sn.sel(variant=name) for name in ("C", REFITTED, "Bhat_prime"))
    assert np.sum((refitted - b_hat_prime) ** 2) < np.sum((c - b_hat_prime) ** 2)
    np.testing.assert_array_equal(xn.sel(variant=WITHOUT), xn.sel(variant="C"))
    wheel = scene_from_table(TABLE | {"upper": TABLE["upper"] | {"rolling_radius": 100.0}}, "wheel")
    scene = replace(calibrated.scene, bodies=wheel.bodies)
    on_wheel = curves(replace(calibrated, scene=scene), "x")
    x, s = on_wheel.x.values, on_wheel.s.values
    upper = wheel.pair.upper
    along = upper.approximate("Bhat", wheel.patch, (x, s)) - upper.approximate("A", wheel.patch, (x, s))
    at_crown = int(np.argmin(np.abs(s)))  # no other turn there than the curvature's
    got = (on_wheel.sel(variant="C") - on_wheel.sel(variant=WITHOUT))[at_crown]
    assert got == pytest.approx(along[0, 2, at_crown] / wheel.patch.area, rel=1e-9)


def curves(calibrated, i):
    """ICs of both bodies in direction i by pressures on the line x = 1.6 mm."""
    ic = ics_with_other_c(calibrated).ic.sel(body="combined", i=i, j="n")
    return ic.isel(point=np.flatnonzero(ic.line.values == "x = 1.6 mm"))


PROPERTIES = {"combined": EffectiveProperties(mismatch_k=Transition(0.1, 12.0, 1.0, 2.0))}
UPPER_ARC = 'contour = { kind = "arc", radius = 10.0, flank_inclination_deg = 25.0 }'


def test_contour_file_is_found_from_folder_of_calibrated_scene(tmp_path):
    """Also through a link to a folder elsewhere."""
    y = np.linspace(-12, 12, 49)
    np.savetxt(tmp_path / "rail.txt", np.column_stack([y, -(y**2) / 25]))
    path = tmp_path / "mine.toml"
    text = scene_text(engine=HARMONIC).replace(
        UPPER_ARC, 'contour = { kind = "points", file = "rail.txt" }', 1
    )
    path.write_text(text, encoding="utf-8")
    scene = load_scene(str(path))
    (tmp_path / "deep" / "er" / "out").mkdir(parents=True)
    (tmp_path / "out").symlink_to(tmp_path / "deep" / "er" / "out")
    for out in (tmp_path / "deep", tmp_path / "out"):
        (out / "again.toml").write_text(with_properties(scene, PROPERTIES), encoding="utf-8")
        again = load_scene(str(out / "again.toml"))
        first, second = (each.bodies["lower"].contour.position(y) for each in (scene, again))
        np.testing.assert_array_equal(first, second)
        assert again.effective == PROPERTIES


@pytest.mark.parametrize(
    "given",
    [
        "",
        "effective.combined.mismatch_k = { far = 0.3, r_inf = 5.0, m = 1.0, n = 1.0 }\n",
        "effective = { lower = { G = { far = 7e4, r_inf = 5.0, m = 1.0, n = 1.0 } } }\n",
    ],
)
def test_calibrated_scene_differs_only_in_variants_and_properties(given, tmp_path):
    """However its effective properties were written; comments stay."""
    text = scene_text(engine=HARMONIC).replace("[lower]", "[lower]  # the rail")
    path = tmp_path / "mine.toml"
    path.write_text(f"# tried on the twin-disc rig\n{given}{text}", encoding="utf-8")
    scene = load_scene(str(path))
    written = with_properties(scene, PROPERTIES)
    assert written.startswith("# tried on the twin-disc rig\n")
    assert "[lower]  # the rail" in written
    after, before = tomllib.loads(written), tomllib.loads(scene.text)
    assert after.pop("variants") == [*scene.variants, "Bhat_prime"]
    effective = after.pop("effective")
    assert effective.pop("combined") == {"mismatch_k": {"far": 0.1, "r_inf": 12.0, "m": 1.0, "n": 2.0}}
    previous = before.pop("effective", {})
    assert effective == {name: table for name, table in previous.items() if name != "combined"}
    before.pop("variants", None)
    assert after == before


def test_properties_of_each_body_replace_combined_properties():
    """Those of both would outweigh them."""

    def written(scene, properties):
        return scene_from_table(tomllib.loads(with_properties(scene, properties)), "mine")

    scene = written(scene_from_table(TABLE, "mine"), PROPERTIES)
    assert scene.pair.effective
    again = written(scene, dict.fromkeys(("lower", "upper"), PROPERTIES["combined"])).pair
    assert again.effective is None
    assert again.has_effective("combined")


@pytest.mark.slow
def test_report_of_few_variants_and_properties_of_each_body_is_written(made, tmp_path):
    """Figures need A, B, B-hat whatever the scene lists; two scenes may have different properties."""
    path, out = made
    table = "bodies = ['lower', 'upper']\nproperties = ['G', 'nu']\ncomponents = ['xn', 'nn']\n"
    text = path.read_text(encoding="utf-8").replace(CALIBRATION, CALIBRATION + table)
    other = tmp_path / "other.toml"
    other.write_text('variants = ["Bhat"]\n' + text, encoding="utf-8")
    store = ["--store", str(out / "store"), "--out", str(tmp_path / "o")]
    assert exit_code(["calibrate", str(path), str(other), *store]) == DONE
    with xr.open_dataset(tmp_path / "o" / "other" / "calibration.nc", engine="h5netcdf") as dataset:
        assert list(dataset.body.values) == ["lower", "upper"]
        assert dataset.sizes["parameter"] == 8
    scene = load_scene(str(tmp_path / "o" / "other" / "other_calibrated.toml"))
    assert scene.variants == ("Bhat", "Bhat_prime")
    assert set(scene.effective) == {"lower", "upper"}
    html = (tmp_path / "o" / "calibration.html").read_text(encoding="utf-8")
    assert all(f"{body}, {name}" in html for body in ("lower", "upper") for name in ("G [MPa]", "ν [-]"))


TABLE = tomllib.loads(scene_text(engine=HARMONIC))


def test_curvature_apart_recovers_k_of_prismatic_bodies():
    """ICs that are B-hat-prime of prismatic bodies and what the wheel's curvature adds to B-hat."""
    wheel = TABLE | {"upper": TABLE["upper"] | {"rolling_radius": 100.0}}
    true = Transition(-0.1, 9.0, 1.2, 3.0)
    transitions = {}
    for curvature in ("contained", "apart"):
        calibration = TABLE["calibration"] | {"curvature": curvature}
        scene = scene_from_table(wheel | {"calibration": calibration}, "wheel")
        empty = target_from(scene, np.ones((1, 80)))
        points = empty.x, empty.s
        prismatic = scene_from_table(TABLE, "prismatic").pair
        with_k = replace(prismatic, effective=EffectiveProperties(mismatch_k=true))
        ics = with_k.approximate("Bhat_prime", scene.patch, points)[0, 2]
        for body in ("upper", "lower"):
            curved, straight = (
                getattr(pair, body).approximate("Bhat", scene.patch, points)[0, 2]
                for pair in (scene.pair, prismatic)
            )
            ics = ics + curved - straight
        transitions[curvature] = fit(replace(empty, ics=ics[None])).effective.mismatch_k
    np.testing.assert_allclose(transitions["apart"].at(points[0], 0.0), true.at(points[0], 0.0), rtol=1e-6)
    assert abs(transitions["contained"].far - true.far) > 0.02


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ("s = [4000.0]", "calibration.x_max: points 4000.08 mm away, more than half of"),
        ('properties = ["E"]', "calibration.properties.0"),
        ('properties = ["G", "G"]', "G given twice"),
        ('components = ["xn", "xn"]', "xn given twice"),
        ("s = []", "no line given"),
        ("x_min = 10.0\nx_max = 12.0", "calibration: points lie 10"),
        ('[effective.combined]\ncurvature = "apart"', "effective.combined: no property given"),
        (None, "calibration: xn: all ICs are 0"),  # `flat`
    ],
)
def test_invalid_calibrations_are_refused_before_computation(table, message, tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(harmonic, "build_section", lambda *_: pytest.fail("a mesh was made"))
    path = tmp_path / "mine.toml"
    engine = HARMONIC.replace(CALIBRATION, f"\n[calibration]\n{table}\n")
    path.write_text(scene_text(engine=engine), encoding="utf-8")
    scene = "flat" if table is None else str(path)
    assert exit_code(["calibrate", scene, "--out", str(tmp_path / "o")]) == WRONG_INPUT
    assert message in " ".join(capsys.readouterr().err.split())
