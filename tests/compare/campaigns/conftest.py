"""What tests of campaigns share: a cluster in this process, scenes that are not computed."""

import shutil

import pytest

from tests.compare.campaigns.campaigns import (
    LIGHT,
    all_are_large,
    campaign_in,
    in_this_process,
    light,
    register,
    swept,
)


@pytest.fixture(scope="session")
def client():
    """One for all campaigns: to start an event loop takes seconds on a busy machine."""
    with in_this_process() as client:
        yield client


def noted(computed):
    """`light`, which appends to a list of the scenes that are computed."""

    def compute(scene, options):
        computed.append((scene.bodies["lower"].material.E, scene.bodies["upper"].material.nu))
        return light(scene, options)

    return compute


@pytest.fixture
def light_scenes(monkeypatch):
    """A list of the scenes that are computed, which have the results of `light` only."""
    computed = []
    register(monkeypatch, errors=noted(computed))
    return computed


@pytest.fixture(scope="session")
def finished_large(client, tmp_path_factory):
    """The folder of a finished campaign `LIGHT`, whose dataset is large; tests copy it."""
    folder = tmp_path_factory.mktemp("large")
    with pytest.MonkeyPatch.context() as patch:
        all_are_large(patch)
        register(patch, errors=noted([]))
        swept(campaign_in(folder, LIGHT), folder, client)
    return folder


@pytest.fixture
def large_there(finished_large, tmp_path, monkeypatch):
    """The folder of the test has a finished large dataset; further ones are large, too."""
    shutil.copytree(finished_large, tmp_path, dirs_exist_ok=True)
    all_are_large(monkeypatch)


@pytest.fixture
def sweep(client, tmp_path):
    """A function that runs the campaign of a text: the progress at its end, and the dataset."""

    def run(text=LIGHT, options=None, folder=tmp_path, store=None):
        return swept(campaign_in(tmp_path, text), folder, client, options, store)

    return run
