# One target per intention; `make help` lists them. Everything installs into .venv.
PYTHON ?= python3
BIN := .venv/bin
READY := .venv/.ready
TOOLS := .venv/.tools
FEMIC := $(BIN)/femic
INSTALL := $(BIN)/pip install --quiet --disable-pip-version-check --no-compile --constraint constraints.txt

.DEFAULT_GOAL := help
.PHONY: help setup run geometry1 geometry2 flat matrix contact rolling fe-contact sweep calibrate compare frontier validate extremes docs site attack advice mutations calculix test test-all check format bench clean

help:  ## list the targets
	@grep -E '^[a-z0-9-]+:.*##' $(MAKEFILE_LIST) | sed -E 's/:[^#]*## /\t/' | expand -t 14

setup: $(TOOLS)  ## virtual environment, all pinned packages (also those of tests and documents), system libraries

$(READY): pyproject.toml constraints.txt tools/system-libraries.sh
	sh tools/system-libraries.sh $(PYTHON)
	$(PYTHON) -m venv .venv
	$(INSTALL) --editable .
	touch $@

$(TOOLS): $(READY)
	$(INSTALL) --editable '.[dev]'
	touch $@

run: geometry1  ## the main job: ICs of Geometry 1 by finite elements against A, B, B-bar, B-hat

geometry1 geometry2 flat: $(READY)  ## run a built-in scene; the report is out/SCENE/report.html
	$(FEMIC) run $@

matrix: $(READY)  ## the IC matrix of Geometry 2 on a grid; the report is out/geometry2/matrix.html
	$(FEMIC) matrix geometry2

contact: $(READY)  ## frictionless contact of two pairs with A, B, B-hat and C: out/wide/contact.html, out/tall/contact.html
	$(FEMIC) contact wide tall

rolling: $(READY)  ## a wheel that rolls, and is pressed on, with friction, by A, B-hat, B-hat-prime, mix and C (pressed on, by B, too): out/rolling/contact.html, out/compression/contact.html
	$(FEMIC) contact rolling compression

fe-contact: $(READY)  ## contact of `tall` by finite elements, without ICs, beside that by ICs: out/tall/fe_contact.html
	$(FEMIC) fe-contact tall

sweep: $(READY)  ## a campaign: where does B-hat fail, over flank inclination and radius ratio? out/where_bhat_fails/sweep.html
	$(FEMIC) sweep examples/where_bhat_fails.toml

calibrate: $(READY)  ## B-hat-prime fitted to C of both geometries: out/geometry1_geometry2/calibration.html
	$(FEMIC) calibrate geometry1 geometry2

frontier: $(READY)  ## every way to the ICs of Geometry 1, errors against seconds: out/geometry1/frontier.html
	$(FEMIC) frontier geometry1

compare: $(READY)  ## both geometries in one report: out/geometry1_geometry2/report.html
	$(FEMIC) compare geometry1 geometry2

validate: $(READY)  ## statements about these ICs, and about this program, checked with computed verdicts: out/validation/validation.html
	$(FEMIC) validate

extremes: $(TOOLS)  ## every part at its limits and beyond: out/extremes/extremes.html
	$(FEMIC) extremes

docs: $(TOOLS)  ## compute the numbers of the written pages, and write them (an hour)
	$(BIN)/python tools/write_docs.py --compute

site: $(TOOLS)  ## the documentation as a site: out/site/index.html (runs the examples, minutes the first time)
	$(BIN)/python tools/write_docs.py
	$(BIN)/sphinx-build --quiet --fail-on-warning --keep-going --doctree-dir out/doctrees docs out/site

attack: $(TOOLS)  ## kill, damage, race femic, feed it what nobody should write: docs/evidence/extremes.md (an hour)
	$(BIN)/python tools/attack --page
	$(BIN)/python tools/write_docs.py

advice: $(TOOLS)  ## random scenes with and without C, for the adviser: docs/evidence/advice.md (hours; resumes)
	$(BIN)/python tools/advice_study.py
	$(BIN)/python tools/write_docs.py

mutations: $(TOOLS)  ## small changes of the code: do the tests notice? (hours; resumes)
	$(BIN)/python tools/mutations.py

calculix: $(READY)  ## C, contacts and stresses judged by CalculiX (`apt install calculix-ccx`): docs/evidence/other-programs.md (ten minutes)
	$(BIN)/python tools/calculix --record
	$(BIN)/python tools/write_docs.py

test: $(TOOLS)  ## all tests but the slow ones (minutes)
	$(BIN)/pytest

test-all: $(TOOLS)  ## all tests
	$(BIN)/pytest -m ''

check: $(TOOLS)  ## format, lint, types, direction of imports
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy
	$(BIN)/lint-imports

format: $(TOOLS)  ## format the code
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .

bench: $(TOOLS)  ## seconds, memory and errors, for docs/evidence (an hour)
	$(BIN)/python benchmarks/analytic.py --record
	$(BIN)/python benchmarks/effective_bodies.py --record
	$(BIN)/python benchmarks/engines.py --record
	$(BIN)/python benchmarks/finite_strain.py --record
	$(BIN)/python benchmarks/elimination.py --record
	$(BIN)/python benchmarks/matrix.py --record
	$(BIN)/python benchmarks/contact_discount.py --record
	$(BIN)/python benchmarks/normal_contact.py --record
	$(BIN)/python benchmarks/rolling_contact.py --record
	$(BIN)/python benchmarks/small_contacts.py --record
	$(BIN)/python benchmarks/track_geometry.py --record
	$(BIN)/python benchmarks/commands.py --record
	$(BIN)/python benchmarks/solid_engine.py --record
	$(BIN)/python tools/write_docs.py

clean:  ## remove results and the virtual environment
	rm -rf out docs/gallery .venv .mypy_cache .ruff_cache .pytest_cache .import_linter_cache .hypothesis
