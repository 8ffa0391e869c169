# Two commands do everything: `make demo` and `make test`. Each makes the environment in .venv first if it is not there.
PYTHON ?= python3
PIP_ARGS ?=
VENV := .venv
BIN := $(VENV)/bin
READY := $(VENV)/.ready
# What renders rooms, measures benchmarks, repeats the paper, makes environments of its own or drives a browser.
NOT_CORE := $(addprefix tests/,benchmarks capture reproduction simulation \
	deploy/test_export.py cli/test_demo.py scenes/test_bundled.py labelling/test_page.py)

.PHONY: demo test test-core lint docs clean help

help:
	@echo "make demo   train on the bundled kitchen and search it; ends with where to look (about 5 minutes)"
	@echo "make test   the tests, those of indoor_rooms too (about 8 minutes)"
	@echo "make test-core  the tests without rendering, benchmarks and the paper again (about 3 minutes)"
	@echo "make lint   ruff, mypy, and which folder may import which"
	@echo "make docs   the generated blocks of README and docs, from benchmarks/ and the commands' help"
	@echo "make clean  remove .venv, demo/ and caches"

demo: $(READY)
	$(BIN)/active-perceiver demo --out demo --force

test: $(READY)
	OMP_NUM_THREADS=1 $(BIN)/python -m pytest -n 2 --dist loadgroup $(PYTEST_ARGS)

test-core: $(READY)
	OMP_NUM_THREADS=1 $(BIN)/python -m pytest -n 2 --dist loadgroup tests $(NOT_CORE:%=--ignore=%) $(PYTEST_ARGS)

lint: $(READY)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports --no-cache

docs: $(READY)
	$(BIN)/python -m docs.generate

$(READY): pyproject.toml indoor_rooms/pyproject.toml constraints.txt
	@$(PYTHON) -c 'import sys; sys.exit("Python 3.10 or newer is needed: make PYTHON=python3.12 ..." if sys.version_info < (3, 10) else 0)'
	test -x $(BIN)/python || $(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check $(PIP_ARGS) -c constraints.txt -e ./indoor_rooms -e '.[train,rooms,dev]'
	touch $@

clean:
	rm -rf $(VENV) demo .pytest_cache .mypy_cache .ruff_cache .hypothesis .import_linter_cache
