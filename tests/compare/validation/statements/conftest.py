"""What tests of statements share: the measure of a body's errors is made once for all of its curves."""

import pytest

from compare.validation.statements import curves


@pytest.fixture(autouse=True)
def _measures_once(monkeypatch):
    """Keep the measures of a test by results, which never change, and body."""
    measure_of, known = curves.measure_of, {}

    def once(results, body):
        key = id(results), body
        if key not in known:
            known[key] = results, measure_of(results, body)  # the results, too: their id stays their own
        return known[key][1]

    monkeypatch.setattr(curves, "measure_of", once)
