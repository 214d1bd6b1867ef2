"""The scenes that decide statements, and the selection of statements; nothing is solved."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from approx.variants import VARIANTS
from compare.validation.statements import runs as module
from compare.validation.statements.page import STATEMENTS, select_statements
from compare.validation.statements.runs import GEOMETRIES, Runs
from femic.reference.engines import HARMONIC
from femic.reference.run_options import RunOptions
from geometries.errors import WrongInput
from geometries.patches import COMPONENTS

INF = float("inf")


@pytest.fixture
def recorded(monkeypatch):
    """Runs that compute nothing, and the scenes that they would compute."""
    scenes = []

    def compute(scene, _):
        scenes.append(scene)
        return scene

    monkeypatch.setattr(module, "compute", compute)
    return Runs(RunOptions(1), tolerance=0.007), scenes


def test_what_has_a_name_is_computed_once_by_each_memory():
    runs, values, memory = Runs(RunOptions(1), tolerance=0.007), iter(range(9)), {}
    assert [runs.once("one", lambda: next(values)) for _ in range(2)] == [0, 0]
    assert [runs.once("one", lambda: next(values), memory) for _ in range(2)] == [1, 1]
    assert memory == {"one": 1}


def test_a_geometry_has_all_components_and_variants_and_is_computed_once(recorded):
    runs, scenes = recorded
    for name in (*GEOMETRIES, *GEOMETRIES):
        assert runs.geometry(name).name == name
    assert [scene.name for scene in scenes] == list(GEOMETRIES)
    for scene in scenes:
        assert scene.components == COMPONENTS
        assert set(scene.variants) == set(VARIANTS) - {"Bhat_prime"}
        assert scene.compared == ("combined", "lower", "upper")
        assert (scene.settings.engine, scene.settings.tolerance, scene.check) == (HARMONIC, 0.007, None)
    both = runs.with_both_engines("geometry1")
    assert both.check is not None
    assert (both.settings.tolerance, both.components, len(scenes)) == (0.007, COMPONENTS, 3)


def test_the_other_poisson_ratio_belongs_to_the_other_geometry(recorded):
    runs, _ = recorded
    first, second = GEOMETRIES
    for name, other in ((first, second), (second, first)):
        for body, own in runs.geometry(name).bodies.items():
            changed = runs.other_nu(name).bodies[body]
            assert changed.material.nu == runs.geometry(other).bodies[body].material.nu != own.material.nu
            assert changed.material.E == own.material.E
            assert changed.rolling_radius == own.rolling_radius


def test_a_wheel_that_is_not_revolved_differs_in_nothing_else(recorded):
    runs, _ = recorded
    wheel, prismatic = runs.geometry("geometry2"), runs.not_revolved()
    assert [scene.bodies["upper"].rolling_radius for scene in (wheel, prismatic)] == [500.0, INF]
    for scene in (wheel, prismatic):
        assert scene.bodies["lower"].rolling_radius == INF
    s = np.linspace(-20, 20, 41)
    for body in ("lower", "upper"):
        one, other = (scene.bodies[body].contour.inclination(s) for scene in (wheel, prismatic))
        np.testing.assert_array_equal(one, other)


def test_planes_are_flat_and_nearly_so(recorded):
    """Arcs of a thousand reference lengths turn by 2.5 mrad on 25 mm."""
    runs, _ = recorded
    plane, nearly = runs.plane(), runs.nearly_plane()
    for body in ("lower", "upper"):
        assert plane.bodies[body].contour.inclination(25.0) == 0
        assert nearly.bodies[body].contour.inclination(25.0) == pytest.approx(2.5e-3)
    assert nearly.reference_length == 10.0
    assert nearly.patch == runs.geometry("geometry1").patch


def test_a_geometry_is_fitted_to_itself_and_once(recorded, monkeypatch):
    runs, _ = recorded
    fitted = []

    def calibrate(scene, _):
        fitted.append(scene.name)
        return SimpleNamespace(scene=replace(scene, effective={"combined": scene.name}))

    monkeypatch.setattr(module, "compute", lambda scene, _: SimpleNamespace(scene=scene))
    monkeypatch.setattr(module, "calibrate", calibrate)
    monkeypatch.setattr(module, "with_approximations", lambda results, scene: (results, scene))
    for name in (*GEOMETRIES, *GEOMETRIES):
        results, scene = runs.fitted(name)
        assert results is runs.geometry(name)
        assert (scene.effective, scene.variants) == ({"combined": name}, tuple(VARIANTS))
    assert fitted == list(GEOMETRIES)


def test_all_statements_are_selected_unless_some_are_named():
    assert select_statements(None) == tuple(STATEMENTS)
    assert select_statements([9, 1, 9, 21]) == (9, 1, 21)


@pytest.mark.parametrize(
    ("only", "message"),
    [([3, max(STATEMENTS) + 1, 0], f"--only {max(STATEMENTS) + 1} 0"), ([], r"--only \?")],
)
def test_unknown_numbers_of_statements_are_refused_by_name(only, message):
    with pytest.raises(WrongInput, match=rf"^{message}: give some of 1 to {max(STATEMENTS)}$"):
        select_statements(only)
