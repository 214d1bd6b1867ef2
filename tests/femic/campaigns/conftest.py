"""What tests of campaigns share: a cluster in this process, scenes that are not computed."""

import pytest

from femic.campaigns.results import registry
from femic.campaigns.results.kind import ResultKind
from tests.femic.campaigns.campaigns import in_this_process, light


@pytest.fixture(scope="module")
def client():
    with in_this_process() as client:
        yield client


@pytest.fixture
def light_scenes(monkeypatch):
    """Scenes are not computed, only their names are added up; who was computed is listed."""
    made = []

    def noted(scene, options):
        made.append((scene.bodies["lower"].material.E, scene.bodies["upper"].material.nu))
        return light(scene, options)

    kinds = {"errors": ResultKind(noted, lambda _: [])}
    monkeypatch.setattr(registry, "KINDS", kinds)
    return made
