"""What `femic contact` writes: numbers, sentences and pictures of a contact, and maps of two scenes."""

import numpy as np
import pytest
import xarray as xr

from compare.contact.compute import compute_contact
from compare.contact.dataset import to_dataset
from compare.contact.page import summary, write_contact, write_sensitivity
from compare.contact.sensitivity import shape_of
from compare.contact.sensitivity import summary as sensitivity_summary
from femic.contact.pairs.sensitivity import mapped, sensitivities
from femic.scenes.load import load_scene, scene_from_table
from tests.femic.scenes.changes import arc


@pytest.fixture(scope="module")
def results():
    """Both built-in pairs by A and B-hat, at two loads each."""
    loads = {"wide": [660e3, 5300e3], "tall": [58e3, 310e3]}
    return {
        name: compute_contact(
            load_scene(name, {"contact": {"ics": ["A", "Bhat"], "elements": 12, "loads": of_scene}})
        )
        for name, of_scene in loads.items()
    }


def test_the_file_has_pressures_that_carry_the_loads(results, tmp_path):
    write_contact(results["tall"], tmp_path)
    written = xr.open_dataset(tmp_path / "contact.nc")
    for number, load in enumerate([58e3, 310e3]):
        p, s = written[f"p_{number}"], written[f"s_{number}"]
        area = float(np.diff(written[f"x_{number}"])[0] * np.diff(s)[0])
        cosine = np.cos(written[f"inclination_{number}"])
        assert (p * cosine).sum([f"x_{number}", f"s_{number}"]).values * area == pytest.approx([load, load])
        np.testing.assert_array_equal(written["p_max"][number], p.max([f"x_{number}", f"s_{number}"]))
        assert np.all((p * written[f"gap_{number}"]).values == 0)
    assert (tmp_path / "contact.html").stat().st_size > 1e5


def test_summary_states_the_error_of_a_and_its_onset(results):
    dataset = to_dataset(results["tall"])
    off = dataset.p_max.sel(ics="A") / dataset.p_max.sel(ics="Bhat") - 1
    assert f"A: p_max {float(off.max()):+.1%}" in summary(dataset)
    first = float(dataset.angle.sel(ics="Bhat").min())
    assert float(off.min()) > 0.05
    assert f"p_max is off by more than 5% already at {first:.0f} degrees, the least" in summary(dataset)


def test_onset_lies_between_the_last_case_within_and_the_first_case_beyond(results):
    dataset = to_dataset(results["tall"])
    within = dataset.assign(p_max=dataset.p_max.copy(data=[[1.04, 1.0], [1.3, 1.0]]))
    low, high = sorted(dataset.angle.sel(ics="Bhat").values)
    text = summary(within)
    assert f"p_max is off by more than 5% from between {low:.0f} and {high:.0f} degrees on" in text


def test_the_lateral_force_of_one_ics_alone_is_in_the_summary(results):
    dataset = to_dataset(results["tall"]).sel(ics=["Bhat"])
    aside = dataset.assign(F_y=(("case", "ics"), [[0.0], [31e3]]))
    assert "lateral force on the upper body is +0.100 of the load with B̂ at 310000 N. " in summary(aside)


def shapes(results):
    return {name: shape_of(contacts) for name, contacts in results.items()}


def test_pressures_mapped_onto_their_own_patch_are_the_same(results):
    shape = shape_of(results["wide"])
    assert shape.loading.load == 5300e3  # as the scene says, and not the largest
    np.testing.assert_allclose(mapped(shape, shape), shape.normal.p, atol=1e-9 * shape.normal.p.max())


def test_maps_show_displacements_with_a_minus_displacements_with_bhat(results, tmp_path):
    """Of every pair of scenes; A turns no load away from the normals, so it moves them further."""
    maps = list(sensitivities(shapes(results)))
    assert [(one.pressures, one.patch) for one in maps] == [
        (shape, onto) for shape in ("wide", "tall") for onto in ("wide", "tall")
    ]
    for one in maps:
        inside = one.inside
        assert 0 < np.min(inside) < np.max(inside) < 0.4
    own = shape_of(results["tall"])
    u_a, u_bhat = (own.on_grid.operator(ics)(own.normal.p[..., None])[..., 0] for ics in ("A", "Bhat"))
    np.testing.assert_allclose(maps[3].difference, (u_a - u_bhat) / u_bhat.max(), atol=1e-9)
    assert write_sensitivity(results, tmp_path).stat().st_size > 1e4


def test_summary_names_the_worst_pressures_on_each_patch(results):
    """Those of `wide`, which are spread, on both, as [BVSV] says."""
    largest = {
        (one.pressures, one.patch): np.max(np.abs(one.inside)) for one in sensitivities(shapes(results))
    }
    text = sensitivity_summary(results)
    for scene in results:
        worst = max(results, key=lambda shape: largest[shape, scene])
        assert worst == "wide"
        assert f"On the patch of {scene} A is furthest off under the pressures of {worst}." in text


STRANGE = {  # extra gaps at (x, s): what becomes of the contact
    "two patches along x": lambda x, s: 0.05 * np.maximum(0, 1 - np.abs(x) / 2) + 0 * s,
    "two patches along s": lambda x, s: 0.05 * np.maximum(0, 1 - np.abs(s) / 2) + 0 * x,
    "a spot that is raised": lambda x, s: -0.05 * np.exp(-4 * ((x - 1) ** 2 + s**2)),
    "a row of elements beside a step": lambda x, s: np.where(np.abs(x) < 4.9, 1e3, 0.0) + 0 * s,
}


@pytest.mark.parametrize("name", STRANGE)
def test_contacts_of_any_shape_have_a_page_and_lengths_above_0(name, tmp_path):
    """Nothing may touch at x = 0, approaches may be negative, and patches as narrow as an element."""
    x, s = (values.ravel() for values in np.meshgrid(*[np.linspace(-5, 5, 11)] * 2, indexing="ij"))
    np.savetxt(tmp_path / "gap.txt", np.column_stack([x, s, STRANGE[name](x, s)]))
    body = {"E": 210e3, "nu": 0.3}
    of_contact = {
        "loads": [3e3],
        "ics": ["A", "Bhat"],
        "elements": 12,
        "extra_gap": str(tmp_path / "gap.txt"),
    }
    results = compute_contact(
        scene_from_table(
            {
                "lower": body | arc(60.0, 10.0),
                "upper": body | arc(60.0, 10.2) | {"rolling_radius": 300.0},
                "contact": of_contact,
            },
            name,
        )
    )
    assert write_contact(results, tmp_path).stat().st_size > 1e5
    dataset = to_dataset(results)
    for length in ("a", "b", "aspect", "area"):
        assert np.all(dataset[length] > 0), length
    patches = [len(contact.normal.patches) for contact in results.solved.contacts.values()]
    assert patches == ([1, 1] if name == "a spot that is raised" else [2, 2])
