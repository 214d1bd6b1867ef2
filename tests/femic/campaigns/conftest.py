"""What tests of campaigns share: a cluster in this process, scenes that are not computed."""

import pytest

from tests.femic.campaigns.campaigns import LIGHT, campaign_in, in_this_process, light, register, swept


@pytest.fixture(scope="module")
def client():
    with in_this_process() as client:
        yield client


@pytest.fixture
def light_scenes(monkeypatch):
    """A list of the scenes that are computed, which have the results of `light` only."""
    computed = []

    def compute(scene, options):
        computed.append((scene.bodies["lower"].material.E, scene.bodies["upper"].material.nu))
        return light(scene, options)

    register(monkeypatch, errors=compute)
    return computed


@pytest.fixture
def sweep(client, tmp_path):
    """A function that runs the campaign of a text: the progress at its end, and the dataset."""

    def run(text=LIGHT, options=None, folder=tmp_path, store=None):
        return swept(campaign_in(tmp_path, text), folder, client, options, store)

    return run
