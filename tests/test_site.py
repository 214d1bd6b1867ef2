"""The documentation site is built without a warning, is complete, and asks no other machine for anything."""

import os
import re
import shutil
import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

import pytest

import femic

ROOT = Path(__file__).parents[1]
SOURCES = ("docs", "examples", "tests", "tools")
LINKED = ("LICENSE", "CITATION.cff", "compare/report/plotly/LICENSE")
LOADED = {"script": "src", "img": "src", "source": "src", "iframe": "src", "link": "href"}


class Page(HTMLParser):
    """What a page loads, leads to, and has places for."""

    def __init__(self, path):
        super().__init__()
        self.loaded, self.links, self.ids = [], [], set()
        self.feed(path.read_text(encoding="utf-8"))

    def handle_starttag(self, tag, attrs):
        attributes = dict(attrs)
        if attributes.get(LOADED.get(tag)):
            self.loaded.append(attributes[LOADED[tag]])
        if tag == "a" and attributes.get("href"):
            self.links.append(attributes["href"])
        self.ids |= {attributes.get("id"), attributes.get("name")}


pytestmark = pytest.mark.slow  # links of pages: tests/test_docs.py


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """The folder of the site, whose gallery shows the scripts without running them."""
    root = tmp_path_factory.mktemp("site")
    for folder in SOURCES:
        shutil.copytree(ROOT / folder, root / folder, ignore=shutil.ignore_patterns("gallery", "__pycache__"))
    for file in LINKED:
        (root / file).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / file, root / file)
    options = ["--quiet", "--fail-on-warning", "--keep-going", "-D", "plot_gallery=0"]
    done = subprocess.run(
        [sys.executable, "-m", "sphinx", *options, root / "docs", root / "html"],
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return root / "html"


@pytest.fixture(scope="module")
def pages(site):
    return {path: Page(path) for path in site.rglob("*.html") if "_static" not in path.parts}


def test_no_page_loads_anything_from_elsewhere(site, pages):
    assert len(pages) > 40
    assert not {address for page in pages.values() for address in page.loaded if urlsplit(address).netloc}
    styles = "".join(path.read_text(encoding="utf-8") for path in site.rglob("*.css"))
    assert not re.findall(r"(?:url\(|@import)\s*[\"']?(?:https?:)?//[^)]*", styles)


def test_what_pages_load_and_link_to_within_the_site_is_there(pages):
    for path, page in pages.items():
        for address in page.loaded:
            assert (path.parent / unquote(urlsplit(address).path)).exists(), f"{path.name}: {address}"
        for link in page.links:
            parts = urlsplit(link)
            if not (parts.scheme or parts.netloc):
                target = (path.parent / unquote(parts.path)).resolve() if parts.path else path
                assert target.exists(), f"{path.name}: {link}"
                if parts.fragment and target in pages:
                    assert unquote(parts.fragment) in pages[target].ids, f"{path.name}: {link}"


def test_the_site_has_every_section_public_name_and_example(site, pages):
    links = pages[site / "index.html"].links
    sections = ("start", "decide", "how-to", "theory", "gallery", "reference", "evidence")
    assert [name for name in sections if f"{name}/index.html" not in links] == []
    text = (ROOT / "docs/reference/api.md").read_text(encoding="utf-8")
    named = re.findall(r"^\.\. auto\w+:: femic\.(\w+)$", text, re.MULTILINE)
    assert sorted(named) == sorted(femic.__all__)
    assert {f"femic.{name}" for name in femic.__all__} <= pages[site / "reference/api.html"].ids
    for script in (ROOT / "examples").glob("*.py"):
        assert (site / "gallery" / f"{script.stem}.html").exists(), script.name


def test_formulas_are_rendered_by_the_site_itself(site):
    text = (site / "theory/frames.html").read_text(encoding="utf-8")
    source = (ROOT / "docs/theory/frames.md").read_text(encoding="utf-8")
    assert text.count('<div class="math') == source.count("```math")
    assert re.search(r'<script [^>]*src="\.\./_static/mathjax/', text)
