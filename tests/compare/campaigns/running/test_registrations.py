"""Forms of ICs that a session registers: that workers have the same ones is checked before any work."""

import pytest

from approx.forms import FORMS, Form
from compare.campaigns import dataset as outcomes
from compare.campaigns.cluster import ClusterSize, local_cluster
from compare.campaigns.tasks import PROBE, Unusable, different_registrations, registrations
from femic.cache.store import Store
from tests.approx.new_forms import faded, register
from tests.compare.campaigns.campaigns import OF_UPPER, campaign_in, swept


def test_worker_with_other_registrations_is_refused(tmp_path, monkeypatch):
    with local_cluster(ClusterSize(1, 1000.0)) as client:
        assert list(client.run(different_registrations, registrations()).values()) == [[]]
        register(monkeypatch)
        campaign = campaign_in(tmp_path, OF_UPPER.replace('"Bhat"', '"Btilde"'))
        with pytest.raises(Unusable, match=r"form 'Btilde', .*variant 'Btilde', .*: not registered in a wor"):
            swept(campaign, tmp_path, client)
    assert outcomes.keys_in(Store(tmp_path / "store")) == {PROBE}


def test_form_with_another_definition_is_different(monkeypatch):
    submitted = registrations()
    monkeypatch.setitem(FORMS, "B", Form(faded))
    assert different_registrations(submitted) == ["form 'B'", "variant 'B'", "variant 'mix'"]
    assert different_registrations(registrations()) == []
