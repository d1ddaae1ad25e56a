# Everything works on a fresh clone with git, make and Python 3.11 to 3.14.
.DEFAULT_GOAL := help
.PHONY: help setup run test test-packages test-clients rehearsal lint types docs bench soak soak-memory stress-tables mutants

# Compiled modules are kept: uv compiles none, and the tests start hundreds of processes.
unexport PYTHONDONTWRITEBYTECODE

READY := .venv/.ready
BIN := .venv/bin
WORKERS ?= 3
CYCLES ?= 1000
MINUTES ?= 30
SEED ?= 0
COUNT ?= 100

help:  ## Show what there is
	@sed -n 's/^\([a-z-]*\):.*## \(.*\)/make \1\t\2/p' Makefile | expand -t 20

setup: $(READY)  ## Make .venv with exact versions of everything

$(READY): pyproject.toml constraints.txt tools/setup.sh tools/installers.sh $(wildcard plugins/*/pyproject.toml)
	@PYTHON="$(PYTHON)" INSTALLER="$(INSTALLER)" sh tools/setup.sh

run: setup  ## Set up, and let the Panda drop a cube into the basket
	$(BIN)/bt-manip run pick_place
	@echo "To watch it in the browser: $(BIN)/bt-manip run pick_place --view"

test: setup  ## Set up, and run the tests of bt_manip, in WORKERS processes
	$(BIN)/python -m pytest -n $(WORKERS) --dist loadfile --no-loadscope-reorder

test-packages: setup  ## Test each package of plugins/ where nothing else of this checkout is
	$(BIN)/python tools/test_packages.py

test-clients: setup  ## Test with the learning libraries of users, in environments of their own
	$(BIN)/python tools/test_clients.py

rehearsal: setup  ## Rehearse with simulated arms behind their own protocols; ARMS="franka trossen", CUBES=20 for more
	$(BIN)/python tools/rehearsal.py

lint: setup  ## Check style
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

types: setup  ## Check types
	$(BIN)/mypy

docs: setup .venv/.docs  ## Build the documentation in docs/_build/html
	$(BIN)/python -m sphinx -E -j auto -b html -W --keep-going -q docs docs/_build/html
	@echo "docs/_build/html/index.html"

.venv/.docs: pyproject.toml constraints.txt
	@PYTHON="$(PYTHON)" INSTALLER="$(INSTALLER)" sh tools/setup.sh docs
	@touch .venv/.docs

bench: setup  ## Measure, and print tables, beside other packages where they install
	-@PYTHON="$(PYTHON)" INSTALLER="$(INSTALLER)" sh tools/setup.sh peers
	$(BIN)/python -m benchmarks

soak: setup  ## Run the tests that take minutes, and CYCLES cycles of pick_place with SEED
	$(BIN)/python -m pytest -m soak tests plugins
	$(BIN)/bt-manip run pick_place --cycles $(CYCLES) --seed $(SEED) --quiet --report soak.json

soak-memory: setup  ## Print the memory of a run with page, recording and Groot2 for MINUTES
	$(BIN)/python tools/soak_memory.py --minutes $(MINUTES) --real-time 0

stress-tables: setup  ## Stress all trees, and write the tables to docs/stress_tables.md; takes hours
	$(BIN)/python tools/stress_tables.py --workers $(WORKERS)

mutants: setup  ## Change COUNT numbers and bounds at random by SEED, and print what no test notices
	$(BIN)/python tools/mutants.py --seed $(SEED) --count $(COUNT) --workers $(WORKERS)
