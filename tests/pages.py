"""Pages in a browser: Chromium from the system's packages, without a screen."""

import shutil
from collections.abc import Iterator

import pytest

CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
FLAGS = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]


def started() -> Iterator:
    """Yield the browser, one for all pages of a process."""
    driver = pytest.importorskip("playwright.sync_api", reason="needs the extra femic[dev]")
    if CHROMIUM is None:
        pytest.skip("needs a browser: apt-get install chromium")
    with driver.sync_playwright() as play:
        browser = play.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        yield browser
        browser.close()


def widest(browser, path, width):
    """The width of a page in a window of some width, and of the widest table, all details shown [px].

    The browser must not report an error.
    """
    tab, said = browser.new_page(viewport={"width": width, "height": 900}), []
    tab.on("console", lambda message: said.append(message.text) if message.type == "error" else None)
    tab.on("pageerror", lambda error: said.append(str(error)))
    tab.goto(path.as_uri())
    tab.wait_for_selector("html[data-explore=ready]")
    tab.evaluate("document.querySelectorAll('details').forEach(one => one.open = true)")
    tab.wait_for_timeout(300)
    page = tab.evaluate("document.documentElement.scrollWidth")
    table = tab.evaluate("Math.max(...[...document.querySelectorAll('table')].map(one => one.scrollWidth))")
    tab.close()
    assert not said
    return page, table
