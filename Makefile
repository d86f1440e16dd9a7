# footcal: `make demo` and `make test` each work alone on a fresh machine (Python >= 3.11, pip, make).
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
OUT ?= out
PYTEST_WORKERS ?= 2
BLIND_ROUNDS ?= 30
BLIND_WORKERS ?= 2
FAULT_CASES ?= 1100
FAULT_WORKERS ?= 2

.DEFAULT_GOAL := help

.PHONY: help
help:  ## Show the targets.
	@grep -hE '^[a-z-]+:.*## ' $(MAKEFILE_LIST) | sed -E 's/:.*## /\t/' | expand -t 16

$(VENV)/.installed: pyproject.toml constraints.txt
	$(PYTHON) -m venv $(VENV)
	$(BIN)/pip install --quiet --disable-pip-version-check --constraint constraints.txt --editable .
	@touch $@

$(VENV)/.installed-dev: $(VENV)/.installed
	$(BIN)/pip install --quiet --disable-pip-version-check --constraint constraints.txt --editable '.[dev]'
	@touch $@

.PHONY: install
install: $(VENV)/.installed  ## Create the environment and install footcal.

FOOTCAL := $(BIN)/footcal
BIPED := sample_data/biped

define DEMO_REPORTS
Reports of the demo, in the order of the work; open the last one first:
  $(OUT)/check/report.html       weights as a paper prints them: is the log sound?
  $(OUT)/nao_table2/report.html  the same weights: a straight line does not fit them
  $(OUT)/bench_foot/report.html  weights over holes of a foot: its CoP corrected
  $(OUT)/cells/report.html       weights on eight cells: the calibration to start from
  $(OUT)/stand/report.html       quiet standing: what it shows, and the stance to add
  $(OUT)/walk/report.html        a walk: scales and biases along it, by three methods
  $(OUT)/applied/report.html     another walk: calibrated forces and CoP
  $(OUT)/fleet/report.html       ten months of one cell: when its zero changed
  $(OUT)/hang/report.html        legs hanging four ways: offsets and leg weights
  $(OUT)/pose/report.html        standing poses: how the transducers are mounted
  $(OUT)/simulated/report.html   a simulated walk with a known fault
  $(OUT)/diagnosis/report.html   a walk with a hidden fault: which one, and where
endef
export DEMO_REPORTS

.PHONY: demo
demo: $(VENV)/.installed  ## Install, go the whole road on sample data, say where the reports are.
	$(FOOTCAL) check --recipe recipes/nao_table2.toml --out $(OUT)/check --overwrite --quiet
	$(FOOTCAL) offline-fit --recipe recipes/nao_table2.toml --out $(OUT)/nao_table2 --overwrite --quiet
	$(FOOTCAL) offline-fit --recipe recipes/bench_foot.toml --out $(OUT)/bench_foot --overwrite --quiet
	$(FOOTCAL) offline-fit --recipe recipes/nao_walk.toml --out $(OUT)/cells --overwrite --quiet
	$(FOOTCAL) static-init $(BIPED)/stand_cells.parquet $(BIPED)/stand_body.parquet \
		--recipe recipes/nao_walk.toml --parameters $(OUT)/cells/parameters.json \
		--out $(OUT)/stand --overwrite --quiet
	$(FOOTCAL) online-replay --recipe recipes/nao_walk.toml --compare \
		--parameters $(OUT)/cells/parameters.json --out $(OUT)/walk --overwrite --quiet
	$(FOOTCAL) apply $(BIPED)/walk_002_cells.parquet --recipe recipes/nao_walk.toml \
		--parameters $(OUT)/cells/parameters.json --out $(OUT)/applied --overwrite --quiet
	$(FOOTCAL) batch sample_data/fleet/sessions.csv --command offline-fit \
		--out $(OUT)/fleet --overwrite --quiet
	$(FOOTCAL) hang-calib --recipe recipes/hexapod.toml --out $(OUT)/hang --overwrite --quiet
	$(FOOTCAL) pose-calib --recipe recipes/hexapod.toml \
		--parameters $(OUT)/hang/parameters.json --out $(OUT)/pose --overwrite --quiet
	$(FOOTCAL) simulate --recipe recipes/nao_simulated.toml --out $(OUT)/simulated --overwrite --quiet
	$(FOOTCAL) diagnose $(BIPED)/walk_004_faulty_cells.parquet $(BIPED)/walk_004_faulty_body.parquet \
		--experiment walk --recipe recipes/nao_walk.toml \
		--parameters $(OUT)/cells/parameters.json --out $(OUT)/diagnosis --overwrite
	@echo; echo "$$DEMO_REPORTS"

PYTEST := OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 PYTHONDONTWRITEBYTECODE= \
	$(BIN)/python -m pytest -n $(PYTEST_WORKERS) --dist worksteal --ignore=tests/benchmarks

.PHONY: test
test: $(VENV)/.installed-dev  ## Install what the tests need and run those of up to a second.
	$(PYTEST) -m "not slow and not thorough"

.PHONY: test-thorough
test-thorough: $(VENV)/.installed-dev  ## The tests that take longer, commands from end to end; before a release.
	$(PYTEST) -m "thorough and not slow"

.PHONY: check
check: $(VENV)/.installed-dev  ## Lint, types and tests; before each commit.
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(MAKE) language
	$(MAKE) test

.PHONY: studies
studies: $(VENV)/.installed-dev  ## Slow studies: coverage, bounds, seeds; figures to $(OUT)/studies.txt.
	@mkdir -p $(OUT)
	OMP_NUM_THREADS=1 $(BIN)/python -m pytest -m slow -s | tee $(OUT)/studies.txt

.PHONY: blind
blind: $(VENV)/.installed-dev  ## The sealed blind bench; resumable; writes docs/blind_bench.md.
	OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 $(BIN)/python -m tests.blind \
		--rounds $(BLIND_ROUNDS) --workers $(BLIND_WORKERS) \
		--out $(OUT)/blind --ledger $(OUT)/blind-ledger

.PHONY: papers
papers: $(VENV)/.installed-dev  ## Both source papers, table by table; writes docs/papers.md.
	OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 $(BIN)/python -m tests.papers --out $(OUT)/papers

.PHONY: faults
faults: $(VENV)/.installed-dev  ## Bad inputs and injected faults; resumable; writes docs/reliability.md.
	OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 $(BIN)/python -m tests.faults \
		--cases $(FAULT_CASES) --workers $(FAULT_WORKERS) --out $(OUT)/faults

.PHONY: golden
golden: $(VENV)/.installed-dev  ## Compare all golden outputs; with WHY='...' make them anew.
	OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 $(BIN)/python -m tests.golden $(if $(WHY),--why "$(WHY)")

.PHONY: mutations
mutations: $(VENV)/.installed-dev  ## Seeded mutations of the product: which test catches each.
	$(BIN)/python -m tests.mutations --out $(OUT)/mutations

.PHONY: samples
samples: $(VENV)/.installed-dev  ## Rebuild sample_data/ from the physics engine.
	$(BIN)/python sample_data/make_samples.py

.PHONY: pictures
pictures: demo  ## Run the demo and take the pictures of README and documents from it.
	$(FOOTCAL) simulate --experiment walk --effect imu_tilt=0.02 --recipe recipes/nao_simulated.toml \
		--out $(OUT)/tilted --overwrite --quiet
	$(FOOTCAL) diagnose $(OUT)/tilted/cells.parquet $(OUT)/tilted/body.parquet --experiment walk \
		--recipe recipes/nao_walk.toml --parameters $(OUT)/cells/parameters.json \
		--out $(OUT)/rivals --overwrite --quiet
	$(FOOTCAL) simulate --experiment walk --effect right_fl.channel_stuck=1 \
		--recipe recipes/nao_simulated.toml --out $(OUT)/stuck --overwrite --quiet
	$(FOOTCAL) check $(OUT)/stuck/cells.parquet --recipe recipes/nao_simulated.toml \
		--out $(OUT)/stuck_check --overwrite --quiet
	printf 'Gewicht [g];HX711\n0;84512\n500;295480\n1000;506210\n2000;928010\n5000;2192600\n5000;2193100\n1000;506600\n0;84700\n' > $(OUT)/scale.csv
	cd $(OUT) && COLUMNS=100 $(abspath $(FOOTCAL)) init scale.csv --output scale.toml --overwrite > init.txt
	$(BIN)/python docs/make_pictures.py $(OUT)

.PHONY: gallery
gallery: $(VENV)/.installed-dev  ## Every report at 400, 800, 1280 px, dark and on paper; BEFORE=CHECKOUT too.
	$(BIN)/python -m tests.report.gallery --out $(OUT)/gallery $(if $(BEFORE),--before $(BEFORE))

.PHONY: effects-page
effects-page: $(VENV)/.installed-dev  ## Rebuild docs/effects.md and its figures.
	$(BIN)/python docs/make_effects_page.py

.PHONY: strangers
strangers: $(VENV)/.installed-dev  ## Logs in the shapes that people have: init, one command, the truth.
	OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 $(BIN)/python -m pytest -m slow -s tests/strangers

.PHONY: foreign-calibration
foreign-calibration: $(VENV)/.installed-dev  ## Coverage of every calibration in a foreign world; resumable; writes its page.
	OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 $(BIN)/python -m tests.foreign --out $(OUT)/foreign

.PHONY: docs
docs: $(VENV)/.installed  ## Build the documentation site into site/.
	$(BIN)/pip install --quiet --disable-pip-version-check --editable '.[docs]'
	$(BIN)/mkdocs build --strict
	@echo "open site/index.html"

.PHONY: language
language: $(VENV)/.installed-dev  ## Words and plurals that users must not read.
	$(BIN)/python -m tests.language.words

.PHONY: bench
bench: $(VENV)/.installed-dev  ## Benchmarks: ratios measured in one run; writes docs/benchmarks.md.
	$(BIN)/python -m pytest tests/benchmarks --benchmark-only --benchmark-columns=median,iqr,rounds
	OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 $(BIN)/python -m tests.benchmarks

.PHONY: long
long: $(VENV)/.installed-dev  ## Walks of 1 to 8 h, weights of 3 to 24 h: CPU time and memory of each command.
	OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 $(BIN)/python -m tests.benchmarks.long_logs --out $(OUT)/long

.PHONY: many
many: $(VENV)/.installed-dev  ## 200 sessions: batch against a loop, with a worker killed, by Dask.
	OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 $(BIN)/python -m tests.benchmarks.many_sessions --out $(OUT)/many

.PHONY: format
format: $(VENV)/.installed-dev  ## Format the code.
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .

.PHONY: clean
clean:  ## Remove the environment and all output.
	rm -rf $(VENV) $(OUT) build dist .mypy_cache .ruff_cache .pytest_cache
