# The virtual environment is made once and brought up to date when pyproject.toml changes.
# Another interpreter: make test PYTHON=python3.11    Beside the first: ... VENV=.venv-3.11
VENV ?= .venv
PYTHON ?=
RUN := $(VENV)/bin/python

.PHONY: help demo test test-browser test-transparency lint format bench clean venv

help:
	@echo "make demo   the quadcopter in the browser; Ctrl-C ends it (ARGS=--terminal: without)"
	@echo "make test   lint, types, and all tests (ARGS='-k name' for some of them)"
	@echo "make test-browser   the page of \`view\` in a real browser"
	@echo "make test-transparency   programs of others, plain and instrumented (SUITES=all: half an hour)"
	@echo "make lint   ruff and mypy only       make format   ruff's formatter"
	@echo "make bench  the benchmarks           make clean    removes what was made here"

venv:
	@.ci/setup "$(VENV)" $(PYTHON)

# However make ends, killed too, the demo and its nodes end with it.
demo: venv
	@exec $(shell command -v setpriv >/dev/null && echo setpriv --pdeathsig TERM) \
		$(RUN) -m rosslt_auto demo $(ARGS)

test: lint
	$(RUN) -m pytest -n 2 -m "not browser" $(ARGS)

# Needs Chromium, found on PATH or named by CHROMIUM; `.ci/chromium install` installs it.
test-browser: venv
	@.ci/chromium
	$(VENV)/bin/pip install --quiet playwright
	$(RUN) -m pytest -m browser $(ARGS)

# Programs of others with and without instrumentation; writes the report in docs/transparency.md.
test-transparency: venv
	PYTHONPATH=.:tests $(RUN) -m transparency --report docs/transparency.md $(SUITES) $(ARGS)

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
