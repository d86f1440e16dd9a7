# footcal: `make demo` and `make test` each work alone on a fresh machine (Python >= 3.11, pip, make).
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
OUT ?= out
PYTEST_WORKERS ?= 2

.DEFAULT_GOAL := help

.PHONY: help
help:  ## Show the targets.
	@grep -hE '^[a-z-]+:.*## ' $(MAKEFILE_LIST) | sed -E 's/:.*## /\t/' | expand -t 16

$(VENV)/.installed: pyproject.toml
	$(PYTHON) -m venv $(VENV)
	$(BIN)/pip install --quiet --disable-pip-version-check --editable .
	@touch $@

$(VENV)/.installed-dev: $(VENV)/.installed
	$(BIN)/pip install --quiet --disable-pip-version-check --editable '.[dev]'
	@touch $@

.PHONY: install
install: $(VENV)/.installed  ## Create the environment and install footcal.

.PHONY: demo
demo: $(VENV)/.installed  ## Calibrate the published weights of seed 1 and say where the report is.
	$(BIN)/footcal offline-fit --recipe recipes/seed1_table2.toml --out $(OUT)/seed1_table2 --overwrite

.PHONY: test
test: $(VENV)/.installed-dev  ## Install what the tests need and run them.
	OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 $(BIN)/python -m pytest -n $(PYTEST_WORKERS) -m "not slow"

.PHONY: check
check: $(VENV)/.installed-dev  ## Lint, types and tests; before each commit.
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(MAKE) test

.PHONY: bench
bench: $(VENV)/.installed-dev  ## Benchmarks: ratios measured in one run.
	$(BIN)/python -m pytest tests/benchmarks --benchmark-only --benchmark-columns=median,iqr,rounds

.PHONY: format
format: $(VENV)/.installed-dev  ## Format the code.
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .

.PHONY: clean
clean:  ## Remove the environment and all output.
	rm -rf $(VENV) $(OUT) build dist .mypy_cache .ruff_cache .pytest_cache
