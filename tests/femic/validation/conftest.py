"""The browser of the tests of pages."""

from tests.compare.conftest import browser  # noqa: F401 (a fixture)
