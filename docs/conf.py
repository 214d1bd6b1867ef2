"""Settings of the documentation site (`make site`), whose pages are Markdown for code hosts, too."""

import re
import sys
from importlib.metadata import version as version_of
from pathlib import Path
from typing import Any

from sphinx.application import Sphinx

import femic

ROOT = Path(__file__).parents[1]
PAGE = re.compile(r"docs/([\w/-]+)\.md")  # a page as docstrings name it
PUBLIC = re.compile(rf"`(?P<name>{'|'.join(femic.__all__)})`")
OBJECT = re.compile(r"=([A-Z]\w+)\([^()]*\)")  # an object as a default
sys.path.append(str(ROOT / "tools"))  # for the gallery

project = "femic"
author = "The femic authors"
project_copyright = author
version = release = version_of("femic")

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx-mathjax-offline",
    "sphinx_copybutton",
    "sphinx_design",
    "sphinx_gallery.gen_gallery",
]
exclude_patterns = ["numbers", "templates"]
nitpicky = True
highlight_language = "text"  # of blocks that name none
default_role = "literal"  # docstrings have single backticks

# Markdown
myst_enable_extensions = ["colon_fence", "dollarmath"]
myst_fence_as_directive = ["math"]  # as code hosts have formulas
myst_heading_anchors = 4

# docstrings
autodoc_typehints = "none"  # docstrings say what arguments are
autodoc_member_order = "bysource"

# the gallery
sphinx_gallery_conf = {
    "examples_dirs": "../examples",
    "gallery_dirs": "gallery",
    "filename_pattern": r"(?<!dissimilar_bodies)\.py$",  # takes 20 minutes: shown with its stored picture
    "image_scrapers": ("gallery.picture",),
    "reset_argv": "gallery.arguments",
    "reset_modules": (),
    "run_stale_examples": True,  # femic may have changed; models in the store are not solved again
    "backreferences_dir": None,
    "download_all_examples": False,
    "show_signature": False,
    "write_computation_times": False,
    "min_reported_time": 3600,
    "within_subsection_order": "FileNameSortKey",
}

# the look
html_theme = "pydata_sphinx_theme"
html_title = "femic"
html_static_path = ["_static"]
html_css_files = ["femic.css"]
html_show_sourcelink = False
html_copy_source = False
html_theme_options = {
    "logo": {"text": "femic"},
    "navbar_align": "left",
    "header_links_before_dropdown": 8,
    "footer_start": ["copyright"],
    "footer_end": [],
    "secondary_sidebar_items": ["page-toc"],
    "show_prev_next": False,
    "pygments_light_style": "default",
    "pygments_dark_style": "github-dark",
}
html_sidebars = {"index": []}


def link_names(
    _app: Sphinx, _what: str, _name: str, _obj: object, _options: object, lines: list[str]
) -> None:
    """Make links of the pages and public names that a docstring names."""
    lines[:] = [PUBLIC.sub(r":py:obj:`~femic.\g<name>`", PAGE.sub(r":doc:`/\1`", line)) for line in lines]


def shorten_defaults(*event: Any) -> tuple[str | None, str | None]:
    """Show objects that are defaults without their fields, of which some depend on the machine."""
    *_, signature, returned = event
    return OBJECT.sub(r"=\1()", signature) if signature else signature, returned


def link_gallery(_app: Sphinx, _page: str, source: list[str]) -> None:
    """Lead from scripts to their pages in the gallery; on a code host links lead to the scripts."""
    source[0] = re.sub(r"\]\((?:\.\./)+examples/(\w+)\.py\)", r"](/gallery/\1.rst)", source[0])


def setup(app: Sphinx) -> None:
    app.connect("autodoc-process-docstring", link_names)
    app.connect("autodoc-process-signature", shorten_defaults)
    app.connect("source-read", link_gallery)
