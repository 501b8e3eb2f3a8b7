# Every target sets itself up: Python >= 3.11 with venv, and make, are all it needs. `make demo FRAMES=200` ends sooner.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin

.PHONY: help demo page bundle data test thorough mutants docs lint clean
.DEFAULT_GOAL := demo

help:  ## list the targets
	@awk -F ':.*## ' '/^[a-z]+:.*## / { printf "%-10s %s\n", $$1, $$2 }' $(MAKEFILE_LIST)

# Tests start hundreds of worker processes. If the environment forbids Python to write bytecode, each would compile its modules again.
export PYTHONDONTWRITEBYTECODE :=

$(BIN)/python:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { echo "followspot needs Python >= 3.11; name one: make PYTHON=python3.12"; exit 2; }
	@$(PYTHON) -m venv $(VENV)
	@$(BIN)/pip install --quiet --disable-pip-version-check --upgrade pip || echo "pip could not be upgraded"  # a new pip takes half the time

$(VENV)/demo: pyproject.toml | $(BIN)/python
	@$(BIN)/pip install --quiet --disable-pip-version-check --editable .
	@touch $@

$(VENV)/dev: pyproject.toml | $(BIN)/python
	@$(BIN)/pip install --quiet --disable-pip-version-check --editable '.[dev,docs]'
	@touch $(VENV)/demo $@

demo: $(VENV)/demo  ## track glowing balls in a simulated room
	@$(BIN)/followspot run graphs/glowballs.yaml $(if $(FRAMES),--frames $(FRAMES))

$(VENV)/page: $(VENV)/demo
	@$(BIN)/pip install --quiet --disable-pip-version-check --editable '.[dashboard,recording,web]'
	@touch $@

page: bundle  ## track them live and without end, on a page in a browser
	@$(BIN)/followspot run graphs/glowballs.yaml --set camera.realtime=true --set camera.frames=0 --dashboard

bundle: $(VENV)/page  ## the page's own files, for --dashboard with any graph
	@$(BIN)/python tools/bundle.py

data: $(VENV)/demo  ## list the public data of experiments; NAMES="..." fetches some
	@$(BIN)/python tools/get_data.py $(NAMES)

# One test process for each core and one more, because many tests wait. BLAS gets one thread, because threads of several
# processes would wait for each other. The hypothesis profile ci sets no deadlines, which fail on a busy machine.
WORKERS := $(shell expr $$(nproc 2>/dev/null || echo 3) + 1)
PYTEST := OPENBLAS_NUM_THREADS=1 $(BIN)/python -m pytest --numprocesses $(WORKERS) --maxprocesses 4 --dist loadfile --no-loadscope-reorder --hypothesis-profile ci

# Plain assertions are compiled once for all test processes. Failed tests run again with rewritten assertions, which show the
# values that differ. -rs prints the reasons of skipped tests.
test: $(VENV)/dev  ## the tests
	@$(PYTEST) --assert=plain -rs -m 'not thorough' || { $(PYTEST) -m 'not thorough' --last-failed --last-failed-no-failures none; false; }

thorough: $(VENV)/dev  ## the tests that cost much: more fusions, placements and edges
	@$(PYTEST) -m thorough

$(VENV)/mutants: $(VENV)/dev
	@$(BIN)/pip install --quiet --disable-pip-version-check --editable '.[mutants]'
	@touch $@

# SAMPLE=200 SEED=1 MODULES="core/followspot/worker ..." TESTS=tests: see tools/mutants.py. After Ctrl-C the same command goes on.
mutants: $(VENV)/mutants  ## change the code at random places: does a test notice?
	@nice -n 15 $(BIN)/python tools/mutants.py $(if $(SAMPLE),--sample $(SAMPLE)) $(if $(SEED),--seed $(SEED)) $(if $(MODULES),--modules $(MODULES)) $(if $(TESTS),--tests $(TESTS)) $(if $(AGAIN),--again)

docs: $(VENV)/dev  ## the documents as pages, runs/docs/index.html
	@$(BIN)/sphinx-build --quiet --fail-on-warning --keep-going docs runs/docs

lint: $(VENV)/dev  ## style, types, layers
	@$(BIN)/python tools/bundle.py style types
	@$(BIN)/ruff check .
	@$(BIN)/ruff format --check .
	@$(BIN)/mypy
	@$(BIN)/lint-imports

clean:  ## remove the environment, the bundle of the page, the outputs of runs and all caches
	@rm -rf $(VENV) web/node_modules tools/commands/followspot_page/static runs .mypy_cache .ruff_cache .pytest_cache .hypothesis .import_linter_cache
