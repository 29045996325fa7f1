# One line per target; `make help` lists them.
PYTHON ?= python3
BIN := .venv/bin

.DEFAULT_GOAL := help
.PHONY: help run test test-slow reliability hosts lint types layers fix fmus ssp data figures paper bench clean

help:  ## list the targets
	@grep -hE '^[a-z-]+:.*##' $(MAKEFILE_LIST) | sed -E 's/:.*## /\t/' | expand -t 14

.venv/user: pyproject.toml
	$(PYTHON) -m venv .venv && $(BIN)/python -m pip install --quiet --upgrade pip && $(BIN)/pip install --quiet --editable . && touch $@

.venv/developer: .venv/user
	$(BIN)/pip install --quiet --editable '.[dev]' && touch $@

run: .venv/user  ## install, build the FMUs, simulate Case 1; results and picture in results/
	$(BIN)/curvesqueal build && $(BIN)/curvesqueal run case1 --picture

test: lint types layers  ## lint, types, layers, tests and doctests
	$(BIN)/python -m pytest -n 2 --dist loadfile -m "not slow"

test-slow: .venv/developer  ## the tests that take minutes
	$(BIN)/python -m pytest -n 2 -m slow

reliability: .venv/developer  ## the tests of reliability in full number; writes their figures into docs/reliability.md (an hour)
	CURVESQUEAL_RELIABILITY=1 $(BIN)/python -m pytest -m slow tests/reliability

hosts: .venv/developer  ## an environment of its own for hosts that want other versions of what is used here
	test -x .venv/hosts/bin/python || { $(PYTHON) -m venv .venv/hosts && .venv/hosts/bin/pip install --quiet "cofmupy>=1.0"; }

lint: .venv/developer  ## style and errors (ruff)
	$(BIN)/ruff check . && $(BIN)/ruff format --check .

types: .venv/developer  ## static types (mypy)
	$(BIN)/mypy

layers: .venv/developer  ## who may import whom (import-linter)
	$(BIN)/lint-imports

fix: .venv/developer  ## repair what ruff can repair
	$(BIN)/ruff check --fix . ; $(BIN)/ruff format .

fmus: .venv/user  ## build the FMUs and the SSP into build/
	$(BIN)/curvesqueal build

ssp: .venv/user  ## write the SSDs and parameter sets in ssp/ from the contract
	$(BIN)/python -c "from pathlib import Path; from fmus.packaging.build import write_system_structure; write_system_structure(Path('ssp'))"

data: .venv/user  ## make the shipped wheel and rail data again
	$(BIN)/python -m fmus.wheel.finite_elements && $(BIN)/curvesqueal rail regenerate

figures: .venv/user  ## pictures of the rail (Figs 3, 4), friction (Fig. 5), wheel (Fig. 6) and stability (Fig. 7)
	$(BIN)/curvesqueal rail figures --out results && $(BIN)/curvesqueal friction && $(BIN)/curvesqueal wheel figures && $(BIN)/curvesqueal stability case1 --out results/stability.png

paper: .venv/user  ## docs/paper.md: every table, figure and claim of the paper next to ours (10 minutes)
	rm -rf results/paper
	for case in case1 case2 case3 case4 inferred1 inferred2 inferred3 inferred4; do $(BIN)/curvesqueal run $$case --out results/paper || exit 1; done
	$(BIN)/curvesqueal paper --results results/paper

bench: .venv/developer  ## time per step of the components and of several masters, as ratios
	$(BIN)/python benchmarks/steps.py && $(BIN)/python benchmarks/masters.py && $(BIN)/python benchmarks/setup.py && $(BIN)/python benchmarks/cycles.py

clean:  ## remove what was built
	rm -rf build results .venv .pytest_cache .mypy_cache .ruff_cache .hypothesis
