"""What is kept of a scene is what its own commands compute, under names that are known beforehand."""

import tomllib

import numpy as np
import pytest

from compare.campaigns.kinds import DISTANCES, END_OF_CURVE, KINDS, merge
from compare.studies.frontier import AS_CHEAP, cheapest
from femic.cache.store import Store
from femic.reference.run_options import Level, RunOptions
from femic.results import stressed_contact as lattice
from femic.results.contact import compute_contact
from femic.results.friction import compute_with_friction
from femic.results.ics import compute
from femic.results.ics_dataset import to_dataset as ics_dataset
from femic.results.stresses import ACTUAL, HALF_SPACE, compute_stresses
from femic.scenes.errors import BadScene
from femic.scenes.load import scene_from_table
from geometries.errors import Failure
from tests.coarse import coarse_sections
from tests.compare.campaigns.campaigns import OF_UPPER, campaign_in, errors_of
from tests.femic.contact.wheel_on_rail import scene as rail_and_wheel

CONTACTS = {
    "frictionless": ({"loads": [2e3, 5e3]}, compute_contact),
    "compression": (
        {"motion": "compression", "loads": [2e3], "friction": [0.3], "ics": ["A"]},
        compute_with_friction,
    ),
    "rolling": (
        {"motion": "rolling", "loads": [200.0], "friction": [0.3], "ics": ["A"], "longitudinal": [0.0, 1e-3]},
        compute_with_friction,
    ),
}


@pytest.fixture(scope="module", autouse=True)
def _coarse():
    """How accurate C is does not matter here."""
    with coarse_sections():
        yield


@pytest.fixture(scope="module")
def options(tmp_path_factory):
    """A store with models that all scenes of this module share."""
    return RunOptions(1, Store(tmp_path_factory.mktemp("store")))


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    campaign = campaign_in(tmp_path_factory.mktemp("scene"), OF_UPPER)
    return campaign.scene((12.0,))


def names_of(dataset):
    return {*map(str, dataset.variables), *map(str, dataset.dims)}


@pytest.mark.parametrize("keep", ["errors", "advice"])
def test_results_on_lines_have_the_declared_names(scene, options, keep):
    assert names_of(KINDS[keep].compute(scene, options)) == KINDS[keep].names


def test_ics_equal_those_of_a_single_run(scene, options):
    kept, results = KINDS["ics"].compute(scene, options), compute(scene, options)
    assert names_of(kept) == KINDS["ics"].names
    alone = ics_dataset(results)
    for name in ("ic", "estimate", "x"):
        np.testing.assert_array_equal(kept[name], alone[name])
    np.testing.assert_array_equal(kept.error, errors_of(results).error.transpose(*kept.error.dims))


def test_known_errors_exceed_errors_by_at_most_the_estimate_of_c(scene, options):
    advice = KINDS["advice"].compute(scene, options)
    errors = errors_of(compute(scene, options)).error.max(["line", "i", "j"])
    known = advice.known_error.sel(body="combined")
    of_c = float(known.sel(variant="C"))
    assert of_c > 0
    for name in ("A", "Bhat"):
        error = float(errors.sel(variant=name, body="combined"))
        assert error <= float(known.sel(variant=name)) <= error + of_c * (1 + 1e-12)


@pytest.mark.parametrize(
    ("known", "seconds", "tolerance", "advised"),
    [
        ([0.1, 0.04, 0.01], [1, 2, 50], 0.02, 2),
        ([0.1, 0.04, 0.01], [1, 2, 50], 0.05, 1),
        ([0.1, 0.04, 0.01], [1, 2, 50], 0.2, 1),  # as cheap as the first, and better
        ([0.1, 0.04, 0.01], [1, AS_CHEAP * 1.01, 50], 0.2, 0),
        ([0.1, 0.04, 0.01], [1, 2, 50], 0.001, -1),
    ],
)
def test_cheapest_sufficient_ics_are_advised(known, seconds, tolerance, advised):
    assert cheapest(np.array(known), np.array(seconds, dtype=float), tolerance) == advised


@pytest.mark.parametrize("kind", CONTACTS)
def test_contacts_equal_those_of_a_single_run(kind, options):
    specification, computed = CONTACTS[kind]
    scene = rail_and_wheel(10.8, **specification)
    kept, alone = KINDS["contact"].compute(scene, options), computed(scene)
    assert names_of(kept) <= KINDS["contact"].names
    assert {"p_max", "estimate_p_max", "approach"} <= {*kept.data_vars}
    alone = alone.rename({name: name + END_OF_CURVE for name in DISTANCES if name in alone})
    for name, values in kept.data_vars.items():
        np.testing.assert_array_equal(values, alone[name].astype(float), err_msg=str(name))


@pytest.fixture(scope="module")
def under_rolling(options):
    """A scene that rolls, what a campaign keeps of its stresses, and what its own command computes."""
    changed = pytest.MonkeyPatch()
    for name, n in (("ALONG_X", 3), ("ALONG_S", 3), ("INTO_DEPTH", 2)):
        changed.setattr(lattice, name, n)
    tables = {
        "stresses": {"fineness": 0.1, "estimated": False},
        "damage": {"yield_stress": 500.0, "hardness": 3e3, "speed": 20.0},
    }
    contact = {
        **{"motion": "rolling", "loads": [2e3], "friction": [0.3], "ics": ["A", "Bhat"]},
        "longitudinal": [-0.01, 0.0, 0.01],
    }
    scene = scene_from_table(tomllib.loads(rail_and_wheel(14.0, **contact).text) | tables, "rolls")
    kept, alone = KINDS["stresses"].compute(scene, options), compute_stresses(scene, options)
    changed.undo()
    return scene, kept, alone


def test_stresses_equal_those_of_a_single_run(under_rolling):
    _, kept, alone = under_rolling
    assert names_of(kept) <= KINDS["stresses"].names
    for body in ("lower", "upper"):
        at_body = alone.sel(body=body)
        for short, name in (("mises", "von_mises"), ("principal", "principal"), ("dang_van", "dang_van")):
            true, flat = (at_body[name].sel(source=source) for source in (ACTUAL, HALF_SPACE))
            assert kept[f"{short}_{body}"] == true
            assert kept[f"half_space_{short}_{body}"] == flat != true
            assert kept[f"depth_{short}_{body}"] == at_body[f"depth_{name}"].sel(source=ACTUAL)
            assert kept[f"{short}_{body}"].attrs["units"] == "MPa"
    for name in ("t_gamma", "work", "largest_depth_Archard", "surface_index", "estimate_work"):
        np.testing.assert_array_equal(kept[name], alone[name])
        assert kept[name].dims == ("ics",)
    assert list(kept.ics.values) == ["A", "Bhat"]


def test_stresses_and_contacts_of_a_scene_are_one_dataset(under_rolling, options):
    """So that names of contacts are unique; ICs of the contact are the same in all."""
    scene, kept, _ = under_rolling
    contact = KINDS["contact"].compute(scene, options)
    both = merge({"contact": contact, "stresses": kept})
    assert {*contact.data_vars, *kept.data_vars} == {*both.data_vars}
    assert both.sizes["ics"] == 2
    others = [kind.names for keep, kind in KINDS.items() if keep != "contact"]
    assert not any(KINDS["contact"].names & names - {"ics"} for names in others)


def test_stresses_need_a_contact_that_has_them(scene):
    with pytest.raises(BadScene, match="give loads"):
        KINDS["stresses"].require(scene)
    KINDS["stresses"].require(rail_and_wheel(10.8, **CONTACTS["compression"][0]))


@pytest.mark.parametrize("keep", ["contact", "stresses"])
@pytest.mark.parametrize("kind", CONTACTS)
def test_models_of_contact_on_automatic_grids_are_listed(kind, keep, monkeypatch):
    """Scenes that share them wait for one."""
    scene = rail_and_wheel(10.8, **CONTACTS[kind][0] | {"ics": ["A", "C"]})
    assert scene.contact.automatic
    jobs_of_run = []

    def note_jobs(jobs, *_, **__):
        jobs_of_run.extend(jobs.values())
        raise Failure("only noted")

    monkeypatch.setattr("femic.contact.pairs.ics.matrices", note_jobs)
    with pytest.raises(Failure, match="only noted"):
        KINDS[keep].compute(scene, RunOptions(1))
    known = [job for jobs in KINDS[keep].jobs(scene) for job in jobs.values()]
    assert len(jobs_of_run) == 2
    assert [key_of(job) for job in known[:2]] == [key_of(job) for job in jobs_of_run]


def key_of(job):
    """The key of the first model of a job."""
    return job.settings.engine.key(job.request(Level()), Store())
