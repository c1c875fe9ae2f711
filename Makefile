# Two commands do everything on a machine with Python >= 3.11 and make: `make solve`, `make test`.

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
# Modules are compiled when they are first imported, which most of them never are.
INSTALL := $(BIN)/python -m pip --quiet --disable-pip-version-check install --no-compile

# The tests start hundreds of processes: each would compile all that it imports.
unexport PYTHONDONTWRITEBYTECODE

# `make solve INSTANCE=my.json METHOD=greedy-guarded` plans something else.
INSTANCE := instances/nominal/nominal-000.json
METHOD := ortools
TIME_LIMIT := 10
PLAN := plan-$(notdir $(INSTANCE))

# Stamps: newer than the files that define the install, so that a second `make` installs nothing.
DEFINITION := pyproject.toml constraints.txt
BASE := $(VENV)/.installed
DEVELOPMENT := $(VENV)/.installed-development
DOCUMENTATION := $(VENV)/.installed-documentation

.DEFAULT_GOAL := help
.DELETE_ON_ERROR:
.PHONY: help solve test lint format docs wheel bench clean

help: ## Show this list
	@sed -n 's/^\([a-z]*\):.*## \(.*\)/  make \1@\2/p' $(MAKEFILE_LIST) | awk -F@ '{printf "%-14s %s\n", $$1, $$2}'

solve: $(BASE) ## Install, plan the first nominal instance with OR-Tools and check the plan
	$(BIN)/python -m adr_opt solve $(INSTANCE) --method $(METHOD) --time-limit $(TIME_LIMIT) --out $(PLAN)
	$(BIN)/python -m adr_opt check $(INSTANCE) $(PLAN)

test: lint ## Install the test extras, then linters, types, import contracts and tests
	$(BIN)/python -m pytest -q --numprocesses auto --dist loadfile --no-loadscope-reorder

lint: $(DEVELOPMENT) ## Linters, types and import contracts only
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

format: $(DEVELOPMENT) ## Format the code and sort the imports
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

docs: $(DOCUMENTATION) ## Build the documentation in site/ (make test builds it too, elsewhere)
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --strict
	@echo "open site/index.html"

wheel: $(DEVELOPMENT) ## Build wheel and sdist in dist/, the wheel with its compiled kernels
	$(BIN)/python bench/wheel.py --out dist

bench: $(DEVELOPMENT) ## Measure the timetable and the planners (docs/benchmarks.md lists the rest)
	$(BIN)/python bench/scale.py timetable
	$(BIN)/python bench/planners.py quality nominal greedy greedy-guarded mcts beam auto@10

clean: ## Remove the virtual environment, caches of tools and written plans
	rm -rf $(VENV) site build dist *.egg-info .pytest_cache .mypy_cache .ruff_cache .hypothesis
	rm -rf .import_linter_cache $(PLAN)
	find . -name __pycache__ -type d -prune -exec rm -rf {} +

$(BIN)/python:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' \
	  || { echo "adr-opt needs Python 3.11 or newer: make PYTHON=/path/to/python3 ..." >&2; exit 1; }
	$(PYTHON) -m venv $(VENV)

$(BASE): $(DEFINITION) | $(BIN)/python
	$(INSTALL) --constraint constraints.txt --editable .
	@touch $@

$(DOCUMENTATION): $(DEFINITION) | $(BIN)/python
	$(INSTALL) --constraint constraints.txt --editable '.[docs]'
	@touch $@

# The development install holds the others, so it renews all stamps.
$(DEVELOPMENT): $(DEFINITION) | $(BIN)/python
	$(INSTALL) --constraint constraints.txt --editable '.[test,dev,docs]'
	@touch $(BASE) $(DOCUMENTATION) $@
