# Everything works from nothing but Python 3.10 or later: the environment is made in .venv.
PYTHON ?= python3
BIN := .venv/bin
PIP := $(BIN)/python -m pip install --quiet --disable-pip-version-check

.PHONY: app demo test lint bench clean

demo: .venv/ready
	@$(BIN)/sdfstent demo -o sdfstent-demo

app: .venv/ready-app

# A process per core; more than four would hold each other up. A file stays in one process, which
# has one thread of BLAS: those of several processes wait for each other.
# Bytecode is kept: every process that a test starts would compile the library anew.
test: .venv/ready-test
	@PYTHONDONTWRITEBYTECODE= OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 QT_QPA_PLATFORM=offscreen $(BIN)/python -m pytest --numprocesses auto --maxprocesses 4 --dist loadfile --no-loadscope-reorder

lint: .venv/ready-lint
	@$(BIN)/ruff check .
	@$(BIN)/ruff format --check .
	@if $(BIN)/python -c 'import sys; sys.exit(sys.version_info < (3, 11))'; then $(BIN)/mypy; \
	  else echo "mypy is left out: the numpy that it is checked with needs Python 3.11"; fi

bench: .venv/ready-bench
	@$(BIN)/python -m benchmarks

clean:
	rm -rf .venv build sdfstent-demo *.egg-info .pytest_cache .hypothesis .ruff_cache .mypy_cache

# A stamp per purpose, so that a second run starts at once. Relative paths only: make cannot name
# targets in folders with spaces.
.venv/ready: pyproject.toml
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 10))' || \
	  { echo "Python 3.10 or later is needed, got $$($(PYTHON) --version); name one: make PYTHON=python3.12" >&2; exit 1; }
	@$(PYTHON) -m venv .venv || \
	  { echo "Python's venv module is needed (on Debian: apt-get install python3-venv)" >&2; exit 1; }
	@echo "Installing into .venv; the first time takes a minute."
	@$(PIP) --editable .
	@touch $@

.venv/ready-app: .venv/ready
	@$(PIP) --editable '.[app]'
	@touch $@

.venv/ready-test: .venv/ready
	@$(PIP) --editable '.[test,slicer,app]'
	@touch $@

.venv/ready-lint: .venv/ready
	@$(PIP) --editable '.[lint]'
	@touch $@

.venv/ready-bench: .venv/ready
	@$(PIP) --editable '.[bench,test]'
	@touch $@
