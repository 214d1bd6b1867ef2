"""What is packed and required: pyproject.toml, the pinned versions and the conda recipe say the same."""

import re
import tomllib
from importlib.metadata import distributions
from pathlib import Path

import yaml
from packaging.requirements import Requirement
from packaging.specifiers import SpecifierSet
from packaging.utils import canonicalize_name

ROOT = Path(__file__).parents[1]
TABLES = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
PROJECT = TABLES["project"]
RECIPE = yaml.safe_load((ROOT / "packaging" / "recipe.yaml").read_text(encoding="utf-8"))
ON_CONDA = {"dask": "dask-core", "gmsh": "python-gmsh", "matplotlib": "matplotlib-base"}


def pinned():
    lines = (ROOT / "constraints.txt").read_text(encoding="utf-8").splitlines()
    pairs = [line.split("==") for line in lines if "==" in line]
    return {canonicalize_name(name): version for name, version in pairs}


def requirements():
    extras = PROJECT["optional-dependencies"].values()
    lines = [*PROJECT["dependencies"], *(line for extra in extras for line in extra)]
    return [one for one in map(Requirement, lines) if one.name != "femic"]


def test_a_tested_version_of_every_requirement_is_pinned():
    versions = pinned()
    for requirement in requirements():
        assert requirement.specifier.contains(versions[canonicalize_name(requirement.name)]), requirement


def test_pinned_versions_can_be_installed_on_the_oldest_python():
    """Debian has 3.11.2: where a pinned version is not for this Python, pip searches without end."""
    oldest = PROJECT["requires-python"].removeprefix(">=") + ".0"
    versions = pinned()
    needs = {
        one.name: one.metadata.get("Requires-Python", "")
        for one in distributions()
        if versions.get(canonicalize_name(one.name)) == one.version
    }
    assert len(needs) > 50
    assert not {name: text for name, text in needs.items() if not SpecifierSet(text).contains(oldest)}


def test_the_conda_recipe_requires_the_same():
    named = dict(line.split(" ", 1) for line in RECIPE["requirements"]["run"])
    assert named.pop("python") == PROJECT["requires-python"]
    expected = {
        ON_CONDA.get(one.name, one.name): one.specifier for one in map(Requirement, PROJECT["dependencies"])
    }
    assert {name: set(text.split(",")) for name, text in named.items()} == {
        name: {str(part) for part in specifier} for name, specifier in expected.items()
    }


def test_the_version_is_the_same_everywhere():
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    assert PROJECT["version"] == RECIPE["package"]["version"] == citation["version"]
    changes = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    assert re.search(rf"^## .*({re.escape(PROJECT['version'])}|[Uu]nreleased)", changes, flags=re.MULTILINE)


def test_type_checkers_see_the_annotations_of_all_packages():
    """A package says with py.typed that it has annotations; the wheel has all files of its packages."""
    wheel = TABLES["tool"]["hatch"]["build"]["targets"]["wheel"]
    assert set(wheel) == {"packages"}  # nothing is excluded
    for package in wheel["packages"]:
        assert (ROOT / package / "py.typed").is_file(), package
