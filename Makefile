# Everything works from nothing but Python 3.10 or later: the environment is made in .venv.
PYTHON ?= python3
VENV ?= .venv
BIN := $(VENV)/bin
PIP := $(BIN)/python -m pip install --quiet --disable-pip-version-check

.PHONY: app demo test test-all lint bench wheel clean

demo: $(VENV)/ready
	@$(BIN)/sdfstent demo -o sdfstent-demo

app: $(VENV)/ready-app

# A process per core and one more, for pages and children are waited for; more than four would hold
# each other up. A file stays in one process, which has one thread of BLAS: those of several
# processes wait for each other.
# Bytecode is kept: every process that a test starts would compile the library anew.
# What more cases of a sweep would say again, and what tests the bench, is left to `make bench`.
test: $(VENV)/ready-test
	@PYTHONDONTWRITEBYTECODE= OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 QT_QPA_PLATFORM=offscreen $(BIN)/python -m pytest --numprocesses $$($(BIN)/python -c 'import os; print(min(os.cpu_count() + 1, 4))') --dist loadfile --no-loadscope-reorder -m "not bench"

# The same with every Python from 3.10 to 3.13 that is there.
test-all:
	@for version in 3.10 3.11 3.12 3.13; do \
	  if python$$version -c '' 2>/dev/null; then \
	    echo "Python $$version:"; $(MAKE) test PYTHON=python$$version VENV=.venv-$$version || exit 1; \
	  else echo "Python $$version is not here."; fi; \
	done

# What `pip install` takes; the panel is inside of it, for it is what `sdfstent app` shows.
wheel: $(VENV)/ready
	@rm -rf build
	@$(BIN)/python -m pip wheel --quiet --no-deps --wheel-dir dist .
	@rm -rf build

lint: $(VENV)/ready-lint
	@$(BIN)/ruff check .
	@$(BIN)/ruff format --check .
	@if $(BIN)/python -c 'import sys; sys.exit(sys.version_info < (3, 11))'; then $(BIN)/mypy; \
	  else echo "mypy is left out: the numpy that it is checked with needs Python 3.11"; fi

bench: $(VENV)/ready-bench
	@$(BIN)/python -m pytest -m bench
	@$(BIN)/python -m benchmarks

clean:
	rm -rf .venv .venv-3.1? build dist sdfstent-demo *.egg-info .pytest_cache .hypothesis .ruff_cache .mypy_cache

# A stamp per purpose, so that a second run starts at once. Relative paths only: make cannot name
# targets in folders with spaces.
$(VENV)/ready: pyproject.toml
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 10))' || \
	  { echo "Python 3.10 or later is needed, got $$($(PYTHON) --version); name one: make PYTHON=python3.12" >&2; exit 1; }
	@$(PYTHON) -m venv $(VENV) || \
	  { echo "Python's venv module is needed (on Debian: apt-get install python3-venv)" >&2; exit 1; }
	@echo "Installing into $(VENV); the first time takes a minute."
	@$(PIP) --editable .
	@touch $@

$(VENV)/ready-app: $(VENV)/ready
	@$(PIP) --editable '.[app]'
	@touch $@

$(VENV)/ready-test: $(VENV)/ready
	@$(PIP) --editable '.[test,slicer,app]'
	@touch $@

$(VENV)/ready-lint: $(VENV)/ready
	@$(PIP) --editable '.[lint]'
	@touch $@

$(VENV)/ready-bench: $(VENV)/ready
	@$(PIP) --editable '.[bench,test]'
	@touch $@
