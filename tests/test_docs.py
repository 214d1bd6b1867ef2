"""Python blocks of the pages run; links, paths and names exist; computed pages are up to date."""

import json
import pkgutil
import re
import runpy
import tomllib
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from femic.cache.digests import STUDY_FOLDERS, results_digest
from femic.cli.main import exit_code
from femic.scenes.load import load_scene, scene_from_table
from femic.scenes.scene_table import tables
from tests.femic.reference.stand_ins import b_hat_as_c

ROOT = Path(__file__).parent.parent
BLOCK = re.compile(r"^```python\n(.*?)^```$", flags=re.DOTALL | re.MULTILINE)
PACKAGES = ("approx", "compare", "femic", "geometries")
FOLDERS = (*PACKAGES, "benchmarks", "docs", "examples", "tests", "tools")
PAGES = sorted(str(page.relative_to(ROOT)) for page in (*ROOT.glob("*.md"), *ROOT.glob("docs/**/*.md")))


def run_blocks(document, without=()):
    """Run the Python blocks of a document one after the other; returns how many there are, and their names.

    Blocks in which some words occur are left out.
    """
    text, namespace = (ROOT / document).read_text(encoding="utf-8"), {}
    blocks = list(BLOCK.finditer(text))
    for block in blocks:
        if any(word in block[1] for word in without):
            continue
        above = "\n" * text.count("\n", 0, block.start(1))  # line numbers of the document
        exec(compile(above + block[1], ROOT / document, "exec"), namespace)
    return len(blocks), namespace


def prose(page):
    """The text of a page without its code blocks."""
    return re.sub(r"^ *```.*?^ *```$", "", (ROOT / page).read_text("utf-8"), flags=re.DOTALL | re.MULTILINE)


def anchors(page):
    """The anchors of a page's headings, as code hosts make them."""
    headings = re.findall(r"^#+ (.*)$", prose(page), flags=re.MULTILINE)
    return {re.sub(r"[^\w -]", "", heading.lower()).replace(" ", "-") for heading in headings}


@pytest.mark.parametrize("page", PAGES)
def test_no_page_has_marks_of_a_merge(page):
    assert not re.search(
        r"^(<<<<<<<|=======|>>>>>>>)( |$)", (ROOT / page).read_text("utf-8"), flags=re.MULTILINE
    )


def resolves(name):
    """Whether a dotted name is a module or an attribute that can be imported."""
    try:
        pkgutil.resolve_name(name)
    except (ImportError, AttributeError):
        return False
    return True


@pytest.mark.parametrize("page", PAGES)
def test_links_files_and_names_of_a_page_exist(page):
    for target in re.findall(r"\]\(([^)\s]+)\)", prose(page)):
        if "://" not in target:
            path, _, anchor = target.partition("#")
            linked = ((ROOT / page).parent / path).resolve() if path else ROOT / page
            assert linked.exists(), target
            assert not anchor or anchor in anchors(linked.relative_to(ROOT)), target
    for text in set(re.findall(r"`([^`\n]+)`", prose(page))):  # all that stands in backticks
        if re.fullmatch(rf"({'|'.join(FOLDERS)})/[\w./-]*", text):
            assert (ROOT / text).exists(), text
        if re.fullmatch(rf"({'|'.join(PACKAGES)})(\.\w+)+", text) and not (ROOT / text).exists():
            assert resolves(text), text


@pytest.fixture(scope="module")
def product():
    """The source of the product: code, scenes, templates."""
    kinds = ("*.py", "*.toml", "*.j2")
    paths = [path for folder in PACKAGES for kind in kinds for path in (ROOT / folder).rglob(kind)]
    return "\n".join(path.read_text("utf-8") for path in paths)


def test_pages_that_the_code_names_exist(product):
    named = set(re.findall(r"docs/[\w/-]+\.md", product))
    assert len(named) > 5
    assert not [page for page in named if not (ROOT / page).exists()]


def test_the_page_on_folders_has_a_row_for_each():
    page = (ROOT / "docs/reference/folders.md").read_text(encoding="utf-8")
    parts = [path.parent for name in ("femic", "compare") for path in (ROOT / name).glob("*/__init__.py")]
    assert len(parts) > 15
    rows = [f"\n| `{part.relative_to(ROOT).as_posix()}/` |" for part in parts]
    assert not [row for row in rows if row not in page]


def test_names_of_the_glossary_are_in_the_code(product):
    """Dotted names can be imported; others are words of the product's source."""
    words = set(re.findall(r"\w+", product))
    rows = re.findall(r"^\|(.*)\|$", prose("docs/reference/glossary.md"), flags=re.MULTILINE)
    names = {name for row in rows for name in re.findall(r"`([^`]+)`", row.rsplit("|", 1)[-1])}
    assert len(names) > 50
    assert not [name for name in names if not (resolves(name) if "." in name else name in words)]


CITED = re.compile(r"\b([A-Z][\w-]+(?:(?:, | and )[A-Z][\w-]+)*)( et al\.)? \(?((?:18|19|20)\d\d)\b")


def test_all_that_pages_of_theory_cite_has_an_entry_among_the_references_that_says_where_it_appeared():
    text = " ".join(prose("docs/theory/index.md").split("## References")[1].split())
    entries = f" {text}".split(" - ")[1:]
    references = {}
    for entry in filter(None, (re.match(r"(.*?) \((\d+)\)(.*)", one) for one in entries)):
        names, year, where = entry.groups()
        references[(*(name.rsplit(" ", 1)[-1] for name in names.split(", ")), year)] = where
    found = [
        (re.split(", | and ", one[1]), one[2], one[3])
        for page in PAGES
        if page.startswith("docs/theory/")
        for one in CITED.finditer(" ".join(prose(page).split("## References")[0].split()))
    ]
    assert len(found) > 20
    for names, others, year in found:
        known = [where for key, where in references.items() if key == (*names, year)]
        if others:
            known = [where for key, where in references.items() if (key[0], key[-1]) == (names[0], year)]
        assert len(known) == 1, (names, year)
    assert not [key for key, where in references.items() if len(where) < 10]


# --- computed pages -------------------------------------------------------------------------------------


@pytest.fixture
def write_docs():
    """The names of the tool that writes computed pages."""
    return runpy.run_path(str(ROOT / "tools/write_docs.py"))


def test_pages_with_computed_numbers_and_the_table_of_the_readme_are_not_written_by_hand(write_docs):
    pages = write_docs["pages"]()
    assert set(pages) == {
        *("reference/command-line.md", "reference/scene-keys.md", "decide/ics-tables.md"),
        *("decide/formulas.md", "decide/stresses.md", "decide/which-ics.md"),
        *("evidence/advice.md", "evidence/validation.md", "evidence/extremes.md"),
        "evidence/limits.md",
        *("evidence/accuracy.md", "evidence/other-programs.md", "evidence/performance.md"),
    }
    for name, text in pages.items():
        assert (ROOT / "docs" / name).read_text(encoding="utf-8") == text, f"{name}: run tools/write_docs.py"
    text = write_docs["readme"]()
    assert text.count("| ± ") > 5
    assert (ROOT / "README.md").read_text(encoding="utf-8") == text, "run tools/write_docs.py"


def test_numbers_are_set_in_type_but_not_in_code(write_docs):
    text = "| -0.3% | (-2) | 1-2 |\n\n\n\n`a -1 2%`\n```\n -3 4%\n```\n"
    assert write_docs["set_in_type"](text) == "| −0.3 % | (−2) | 1-2 |\n\n`a -1 2%`\n```\n -3 4%\n```\n"


@pytest.mark.slow  # the numbers take long: they follow the code at the end of a piece of work
def test_pages_were_computed_by_this_code(write_docs):
    outdated = write_docs["outdated"]()
    assert not outdated, f"{outdated}: run make docs"


@pytest.fixture
def docs(write_docs, tmp_path):
    """The tool, with numbers and templates of our own."""
    code = {"code": results_digest(*STUDY_FOLDERS)}
    files = {
        "a.json": json.dumps(code | {"versions": {"numpy": "9.9"}, "value": 1}),
        "b.json": json.dumps({"x": code | {"y": 2}}),
        "both.md.j2": "{{ a.value }}{{ b.x.y }}\n",
        "second.md.j2": "{{ b.x.y }}\n",
    }
    for name, text in files.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    write_docs["pages"].__globals__.update(NUMBERS=tmp_path, TEMPLATES=tmp_path)
    return write_docs


def test_pages_say_what_computed_their_numbers(docs):
    first, last = docs["pages"]()["both.md"].strip().split("\n\n")
    assert first == "12"
    code = results_digest(*STUDY_FOLDERS)
    assert f"a by code {code}, numpy 9.9; b by code {code}" in last


@pytest.mark.parametrize("other", ["0123456789ab", None])
def test_pages_of_other_code_are_named(docs, other, tmp_path, capsys):
    assert docs["outdated"]() == {}
    assert docs["checked"]() == 0
    old = {"code": other} if other else {}
    (tmp_path / "a.json").write_text(json.dumps({"value": 1, "x": {}} | old), encoding="utf-8")
    assert list(docs["outdated"]()) == ["both.md"]
    assert docs["checked"]() == 1
    assert f"both.md: docs/numbers/a.json by code {other or 'unknown'}" in capsys.readouterr().err


# --- blocks ---------------------------------------------------------------------------------------------


@pytest.mark.slow  # a minute
def test_the_quick_start_runs(tmp_path, monkeypatch):
    """A wheel that is driven pushes; stiffness goes like the ICs; the sides of a wheelset are alike."""
    monkeypatch.chdir(tmp_path)
    blocks, names = run_blocks("docs/how-to/python.md")
    assert blocks == 13
    assert np.all(names["errors"].error.sel(variant="C", j="n") <= 0.1)
    assert names["fitted"].fit.rms.item() < 0.1
    np.testing.assert_allclose(names["pressed"]["load"].sel(case=4e3), 4e3, rtol=1e-6)
    assert np.all(np.diff(names["curve"].F_x.sel(ics="C").squeeze().values) > 0)
    assert np.all(names["curve"].zero_creepage < 0)
    stiff, soft = (names["compressed"].approach.sel(ics=name).squeeze() for name in ("Bhat", "mine"))
    assert np.all(soft > stiff)
    # the written standard is read with the rms error it is smoothed by
    assert np.sqrt(np.mean(names["measured"].data.residual.values ** 2)) == pytest.approx(0.005, rel=1e-3)
    left, right = (names["study"].p_max.sel({"shift": 0.0, "side": side}) for side in ("left", "right"))
    np.testing.assert_allclose(left, right, rtol=1e-9)
    assert names["study"].conicity == pytest.approx(1 / 20, rel=0.05)  # of a cone


def test_the_quick_start_runs_with_b_hat_as_c_and_without_contacts(tmp_path, monkeypatch):
    """Contacts: tests/femic/interface/test_contact.py and the pages below."""
    monkeypatch.chdir(tmp_path)
    b_hat_as_c(monkeypatch)
    blocks, names = run_blocks("docs/how-to/python.md", without=("solve_contact", "compute_shifts"))
    assert blocks == 13
    errors = names["errors"].error
    assert np.all(errors.sel(variant="C", j="n") <= 0.1)
    assert np.all(errors.sel(variant="Bhat", j="n") < 1e-9)
    assert set(names["pair_with_fit"].effective) == {"combined"}
    assert Path("contact_C.txt").is_file()


def test_many_contacts_wear_where_they_slide():
    blocks, names = run_blocks("docs/how-to/many-contacts.md")
    assert blocks == 5
    assert names["free"].force[0] == pytest.approx(0.0, abs=0.1)
    assert np.all(np.diff(names["curve"].F_x) > 0)
    worn, rolled = names["worn"], names["rolled"]
    assert 0 < worn.max() < 0.01
    assert not np.any(worn[rolled.pressures.max(axis=0) == 0])


def test_the_quick_start_needs_few_imports_and_rolling_few_lines():
    text = (ROOT / "docs/how-to/python.md").read_text(encoding="utf-8")
    blocks = [block[1] for block in BLOCK.finditer(text)]
    ours = re.findall(rf"^(?:import|from) ((?:{'|'.join(PACKAGES)})\S*)", "\n".join(blocks), re.MULTILINE)
    assert set(ours) == {"femic"}
    (rolling,) = (block for block in blocks if "femic.Rolling" in block)
    assert len(rolling.strip().splitlines()) <= 15
    assert '"C"' in rolling
    assert "import femic" in rolling


def test_rolling_example_has_consistent_forces():
    """Driven it pushes the wheel on; its creepage without force is below 0; tractions add up to forces."""
    blocks, names = run_blocks("docs/how-to/rolling.md")
    rolled = names["rolled"].squeeze()
    assert blocks == 1
    assert rolled.F_x.sel(xi=1e-3) > 1e4
    assert rolled.zero_creepage < 0
    assert names["p_x"].sum().item() * 0.6 * 0.5 == pytest.approx(0.5 * 0.3 * 1e5, rel=1e-3)


def test_the_input_for_contact_is_complete_and_has_the_distances_less_the_approach(tmp_path, monkeypatch):
    """Geometry 2 touches at the crowns of both arcs: next to them the list has the approach alone."""
    monkeypatch.chdir(tmp_path)
    blocks, names = run_blocks("docs/how-to/contact-file.md")
    assert blocks == 1
    distances = np.loadtxt("contact_distances.txt").reshape(12, 12)  # s, x
    np.testing.assert_allclose(distances, distances[:, ::-1], atol=1e-12)  # symmetric in x and in s
    np.testing.assert_allclose(distances, distances[::-1], atol=1e-9)
    x, s = 0.45, 0.65  # of the element nearest to the middle; wheel of radius 460, arcs of 10 and 10.1 mm
    near = (
        x**2 / (2 * names["pair"].upper.rolling_radius)
        + s**2 / 2 * (1 / 10 - 1 / 10.1)
        - 0.015 * np.cos(s / 10)
    )
    assert distances[6, 6] == pytest.approx(near, rel=2e-3)
    text = (ROOT / "docs/how-to/contact-file.md").read_text("utf-8")
    (shown,) = re.findall(r"^ 3 MODULE\n(.*?)^ 0 MODULE$", text, flags=re.DOTALL | re.MULTILINE)
    values = {line.split("  ")[-1].strip(): line.split() for line in shown.splitlines()}
    grid = [float(one) for one in values["MX, MY, XL, YL, DX, DY"][:6]]
    assert grid == pytest.approx([12, 12, -6 * 0.9, -6 * 1.3, 0.9, 1.3])
    elastic = [float(one) for one in values["GG 1,2"][:4]]
    steels = [getattr(names["pair"], body).material for body in ("upper", "lower")]
    assert elastic == pytest.approx([*(one.nu for one in steels), *(one.G for one in steels)])
    assert values["CHI, DQ, VELOC"][:2] == ["0.0", "0.9"]
    assert values["PEN, CKSI, CETA, CPHI"][0] == "0.0"
    assert values["IBASE, IPLAN"][0] == "9"
    (digits,) = [line.split()[0] for line in shown.splitlines() if line.endswith(" P-B-T-N-F-S")]
    assert (digits[2], digits[3]) == ("3", "0")  # T: steady rolling, N: prescribed approach
    (digits,) = [line.split()[0] for line in shown.splitlines() if line.endswith(" V-L-D-C-M-Z-E")]
    assert (digits[3], digits[6]) == ("9", "0")  # C: ICs of a file, E: no further slip
    assert "'contact_Bhat.txt'" in shown
    assert Path("contact_Bhat.txt").is_file()
    listed = np.loadtxt(shown.split("IBASE, IPLAN\n")[1].splitlines())
    np.testing.assert_allclose(listed, distances, atol=0.51e-5)


def test_the_block_of_the_readme_runs(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    blocks, names = run_blocks("README.md")
    assert blocks == 1
    p_max, estimate = (names["pressed"][name].squeeze() for name in ("p_max", "estimate_p_max"))
    assert p_max.sel(ics="A") > p_max.sel(ics="Bhat") + estimate.sum()


def scene_in(page):
    """The one scene of a page."""
    (scene,) = re.findall(r"^```toml\n(.*?)^```$", (ROOT / page).read_text("utf-8"), re.DOTALL | re.MULTILINE)
    return scene


def test_the_first_contact_is_a_scene_whose_ics_disagree(tmp_path, monkeypatch):
    scene = scene_in("docs/start/first-contact.md")
    monkeypatch.chdir(tmp_path)
    Path("corner.toml").write_text(scene, encoding="utf-8")
    assert exit_code(["contact", "corner.toml"]) == 0
    assert Path("out/corner/contact.html").is_file()
    with xr.open_dataset("out/corner/contact.nc", engine="h5netcdf") as contact:
        p_max, estimate = contact.p_max, contact.estimate_p_max
        larger = (p_max.sel(ics="A") - p_max.sel(ics="Bhat")).values
        assert larger[1] > estimate.sum("ics").values[1]
        assert 0.02 < larger[1] / p_max.sel(ics="Bhat").values[1] < 0.1  # "some percent"


def test_files_of_the_page_on_profiles_are_solved_with_the_profiles_that_it_writes(tmp_path, monkeypatch):
    """A driven wheel pulls, with less than friction allows; the written scene begins where bodies touch."""
    text = (ROOT / "docs/how-to/my-profile.md").read_text(encoding="utf-8")
    scene, wheelset = re.findall(r"^```toml\n(.*?)^```$", text, flags=re.DOTALL | re.MULTILINE)
    monkeypatch.chdir(tmp_path)
    for command in re.findall(r"^femic (profiles \w+ --write .*)$", text, flags=re.MULTILINE):
        assert exit_code(command.split()) == 0
    scene = scene.replace("-0.002, 0.0, 0.002", "0.001, 0.002").replace('["A", "Bhat"]', '["Bhat"]')
    assert "elements" not in scene
    Path("my.toml").write_text(scene.replace("friction = ", "elements = 8\nfriction = "), encoding="utf-8")
    assert exit_code(["contact", "my.toml"]) == 0
    with xr.open_dataset("out/my/contact.nc", engine="h5netcdf") as rolling:
        limit = rolling.friction * rolling.attrs["load"]
        assert ((rolling.F_x > 0) & (rolling.F_x < limit)).all()
    assert load_scene("my.toml").damage.passages > 0
    Path("mine.toml").write_text(wheelset, encoding="utf-8")
    assert exit_code(["shifts", "mine.toml", "--write", "6"]) == 0
    assert exit_code(["contact", "out/mine/mine_left_6.toml", "--ics", "Bhat"]) == 0
    with xr.open_dataset("out/mine_left_6/contact.nc", engine="h5netcdf") as contact:
        assert (abs(contact.s_centre) < contact.b).all()


def test_the_smallest_scene_of_the_reference_is_a_scene():
    table = tomllib.loads(scene_in("docs/reference/scene-keys.md"))
    assert scene_from_table(table, "smallest").bodies["upper"].rolling_radius == 500


def test_the_reference_has_every_key():
    """Every key of every table, also those that are in no built-in scene."""
    text = (ROOT / "docs/reference/scene-keys.md").read_text(encoding="utf-8")
    listed = set(re.findall(r"^\| `(\w+)` \|", text, flags=re.MULTILINE))
    listed |= set(re.findall(r"^##.* `\[(?:\w+\.)?(\w+)\]`$", text, flags=re.MULTILINE))  # tables
    own = [table for table in tables() if table.__module__.startswith("femic.")]  # tests register others
    fields = [(key, field.alias) for table in own for key, field in table.model_fields.items()]
    top = {"lower", "upper", "lines", "effective"}
    top |= {"rail", "wheel", "right_rail", "right_wheel", "track", "wheelset", "rolling"}
    names = {alias or key for key, alias in fields} - top - {"kind", "combined"}
    assert names - listed == set()
