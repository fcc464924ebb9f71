# The virtual environment is made once and brought up to date when pyproject.toml changes.
# Another interpreter: make test PYTHON=python3.11    Beside the first: ... VENV=.venv-3.11
VENV ?= .venv
PYTHON ?=
RUN := $(VENV)/bin/python

.PHONY: help demo test lint format bench clean venv

help:
	@echo "make demo   the main job on two unmodified nodes, in this terminal"
	@echo "make test   lint, types, and all tests (ARGS='-k name' for some of them)"
	@echo "make lint   ruff and mypy only       make format   ruff's formatter"
	@echo "make bench  the benchmarks           make clean    removes what was made here"

venv:
	@.ci/setup "$(VENV)" $(PYTHON)

demo: venv
	@$(RUN) -m rosslt_auto demo

test: lint
	$(RUN) -m pytest $(ARGS)

lint: venv
	$(RUN) -m ruff check
	$(RUN) -m ruff format --check
	$(RUN) -m mypy

format: venv
	$(RUN) -m ruff check --fix
	$(RUN) -m ruff format

bench: venv
	$(RUN) -m benchmarks.table1

clean:
	rm -rf "$(VENV)" build dist .pytest_cache .hypothesis .mypy_cache .ruff_cache *.egg-info
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
