# Every target sets up what it needs in .venv, from the locked requirements, and touches nothing outside the clone.
PYTHON ?= python3
BIN := .venv/bin
INSTALL := $(BIN)/python requirements/install.py
# recordings of others, for tests that skip where they are absent
ifneq ($(wildcard ../shared/data),)
export HEFTING_DATA ?= $(abspath ../shared/data)
endif
ifneq ($(wildcard ../shared/torques),)
export HEFTING_TORQUES ?= $(abspath ../shared/torques)
endif

# bytecode is kept: else each process of the tests would compile all of them anew
unexport PYTHONDONTWRITEBYTECODE

.PHONY: help demo test lint docs bench lock clean

help:  ## list the targets
	@grep -hE '^[a-z]+:.*##' $(MAKEFILE_LIST) | sed -E 's/:.*## /\t/' | expand -t 10

demo: .venv/run.stamp  ## simulate a robot wielding a hammer, identify it, write pictures to demo/
	$(BIN)/hefting demo --output demo

test: .venv/dev.stamp  ## run every test, or those of TESTS="tests/a.py tests/b.py"
	OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 $(BIN)/python -m pytest -n auto --dist loadfile --no-loadscope-reorder $(TESTS)

lint: .venv/dev.stamp  ## formatting, lint and types
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/pyright
	$(BIN)/pyright -p pyright-strict.json

docs: .venv/dev.stamp  ## build the site, docs/_build/html
	$(BIN)/python -m sphinx -n -W --keep-going -q docs docs/_build/html

bench: .venv/dev.stamp  ## speed, against what one would use instead and against the ratios kept in benchmarks/
	$(BIN)/python -m benchmarks

lock: .venv/dev.stamp  ## renew the locked requirements from pyproject.toml
	$(BIN)/pip install --quiet uv
	$(BIN)/python requirements/lock.py

clean:  ## remove the environment and everything made
	rm -rf .venv demo .pytest_cache .ruff_cache dist docs/_build docs/api docs/commands docs/project docs/drawn docs/gallery

.DELETE_ON_ERROR:

.venv/base.stamp:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { echo "Hefting needs Python 3.11 or newer; try: make PYTHON=python3.12 $(MAKECMDGOALS)"; exit 2; }
	@echo "Setting up .venv (once; a few minutes at most) ..."
	$(PYTHON) -m venv .venv
	@touch $@

.venv/run.stamp: .venv/base.stamp requirements/run.txt pyproject.toml
	$(INSTALL) requirements/run.txt
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps --no-build-isolation -e .
	@touch $@

.venv/dev.stamp: .venv/run.stamp requirements/dev.txt
	$(INSTALL) requirements/dev.txt
	@touch $@
