"""What `femic contact` writes of rolling and compression: file, sentences, figures, tables."""

import numpy as np
import pytest
import xarray as xr

from compare.friction import compression_page, rolling_page
from compare.friction.compute import compute_with_friction
from compare.friction.page import cost
from tests.compare.friction.scenes import scene

COARSE = 8  # elements across the patch


@pytest.fixture(scope="module")
def rolled():
    keys = {"motion": "rolling", "loads": [1e4], "longitudinal": [-4e-3, 0.0, 4e-3]}
    return compute_with_friction(scene(10.3, elements=COARSE, friction=[0.5], **keys))


@pytest.fixture(scope="module")
def pressed():
    return compute_with_friction(
        scene(10.3, elements=COARSE, friction=[0.2, 0.5], motion="compression", loads=[5e3, 1e4])
    )


def test_page_and_file_of_rolling_agree(rolled, tmp_path):
    page = rolling_page.ROLLING.write(rolled, tmp_path).read_text(encoding="utf-8")
    written = xr.open_dataset(tmp_path / "contact.nc")
    assert {path.stem for path in (tmp_path / "figures").iterdir()} == {
        f"contact_{name}" for name in ("creep_force", "centre_line", "stick", "work")
    }
    assert page.count("data:image/png;base64,") == 4
    assert rolling_page.summary(written) in page.replace("&#39;", "'")
    for name in ("A", "Bhat"):
        zero = float(written.zero_creepage.sel(ics=name, friction=0.5))
        assert f"<td>{zero:.4g}<br>" in page
    assert np.all(written.F_x.diff("xi") > 0)


def test_summary_of_rolling_states_distances_of_curves(rolled):
    dataset = rolled.copy()
    text, worst = rolling_page.summary(dataset), dataset[["largest", "rms"]].sel(ics="A").max()
    assert f"A: its creep-force curve is up to {float(worst.largest):.1%} of friction times load" in text
    assert f"(root mean square over the creepages at most {float(worst.rms):.1%})" in text


@pytest.mark.parametrize(
    ("largest", "known", "verdict"),
    [
        (
            [0.07, 0.03, 0.0],
            0.0,
            "None of them is within 2% of friction times load from B̂ at all creepages; B",
        ),
        ([0.07, 0.015, 0.0], 0.001, "Within 2% of friction times load from B̂ at all creepages, B suffices."),
        ([0.01, 0.015, 0.0], 0.001, "at all creepages, A and B suffice."),
        ([0.07, 0.019, 0.0], 0.004, "Whether B is within 2% from B̂ at all creepages, estimates leave open."),
        (
            [0.010, 0.013, 0.0],
            0.004,
            "A and B suffice. A and B tie: they differ by less than their estimates.",
        ),
        ([0.060, 0.063, 0.0], 0.004, "with 6.0%. A and B tie: they differ by less than their estimates."),
    ],
)
def test_verdict_follows_from_the_largest_difference_and_its_estimate(rolled, largest, known, verdict):
    """Though all are within 2 % by root mean square."""
    wide = rolled.reindex(ics=["A", "B", "Bhat"], fill_value=0)
    values = (("friction", "ics"), [largest])
    text = rolling_page.summary(
        wide.assign(largest=values, estimate_largest=(values[0], [[known] * 3]), rms=0.01 * wide.rms)
    )
    assert verdict in text
    assert ("tie" in text) == ("tie" in verdict)


def test_the_summary_says_which_contacts_are_less_accurate(rolled):
    assert "less accurate" not in rolling_page.summary(rolled)
    some = rolled.assign(simplified=rolled.simplified.copy(data=[[[True, False, True], [False] * 3]]))
    assert "A: 2 of 3 contacts were solved only with fewer elements" in rolling_page.summary(some)
    assert "B̂: " not in rolling_page.summary(some).split("all creepages")[-1]


def test_summary_states_that_nothing_is_compared_with_one_ics_alone(rolled):
    alone = rolled.sel(ics=["A"])
    assert "No other ICs than A are compared." in rolling_page.summary(alone)


def test_summary_states_the_effect_of_the_displaced_wheel_if_known(rolled):
    moved = rolled.assign(
        displaced_zero_creepage=rolled.zero_creepage - 3e-5, displaced_p_max=0.97 * rolled.p_max.sel(xi=0.0)
    )
    assert (
        "would move the creepage without force by -3e-05 and change p_max by -3.0%, with B̂."
        in rolling_page.summary(moved)
    )
    unknown = rolled.assign(displaced_zero_creepage=np.nan * rolled.zero_creepage)
    assert "displaced wheel" not in rolling_page.summary(unknown)


def test_ics_with_an_exchanged_component_are_solved_drawn_and_named(tmp_path):
    keys = {"motion": "rolling", "loads": [1e4], "longitudinal": [-4e-3, 0.0, 4e-3], "friction": [0.5]}
    dataset = compute_with_friction(scene(10.3, elements=COARSE, ics=["B", "Bhat+sn:B", "Bhat"], **keys))
    page = rolling_page.ROLLING.write(dataset, tmp_path).read_text(encoding="utf-8")
    assert "B̂ (sn B): its creep-force curve is" in page
    assert (
        1e-4
        < float(dataset.rms.sel(ics="Bhat+sn:B", friction=0.5))
        < float(dataset.rms.sel(ics="B", friction=0.5))
    )


def test_the_page_of_compression_says_how_much_slides(pressed, tmp_path):
    page = compression_page.COMPRESSION.write(pressed, tmp_path).read_text(encoding="utf-8")
    dataset = pressed
    last = dataset.isel(load=-1).sel(friction=0.2)
    slides = {name: f"{float(last.sliding_share.sel(ics=name)):.0%}" for name in ("A", "Bhat")}
    assert f"With friction 0.2, {slides['Bhat']} of the contact area slides with B̂" in page
    assert f"{slides['A']} with A." in page
    assert page.count("data:image/png;base64,") == 3
    assert (tmp_path / "contact.nc").is_file()


def test_cost_states_seconds_and_quality_of_c(rolled):
    dataset = rolled.copy()
    assert "C on this grid" not in cost(dataset)
    dataset.attrs |= {
        "C_seconds": 12.3,
        "C_estimate": 0.012,
        "C_asymmetry": 0.061,
        "C_asymmetry_component": "sn",
    }
    text = cost(dataset)
    assert "C on this grid took 12 s; its largest estimated error is 1.20% of the largest C_nn" in text
    assert "both differ by up to 6.1% of the largest C_sn" in text
