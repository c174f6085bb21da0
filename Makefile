# make demo     fit one shipped rig, diagnose another         make lint   formatting, names, types
# make test     lint, then the whole test suite                make lock   pin the dependencies anew
# make clean    remove what make made
# Needs only python3 (3.11 or newer) and make. Another interpreter: make PYTHON=python3.12 test

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
READY := $(VENV)/.ready
DEMO := out/demo-rig1987
DEMO_DIAGNOSIS := out/demo-leaf_springs

.DEFAULT_GOAL := demo
.PHONY: demo test lint lock clean setup

demo: $(READY)
	@$(BIN)/jaxstick fit data/rig1987 --out $(DEMO) --overwrite
	@$(BIN)/jaxstick diagnose data/leaf_springs --out $(DEMO_DIAGNOSIS) --overwrite

# One test process a core: BLAS has one thread in each.
test: lint
	@OPENBLAS_NUM_THREADS=1 $(BIN)/python -m pytest -q -n auto --dist loadfile --no-loadscope-reorder --durations 12

lint: $(READY)
	@$(BIN)/ruff check --quiet --output-format concise .
	@$(BIN)/ruff format --check --quiet .
	@$(BIN)/pyright --pythonpath $(BIN)/python

setup: $(READY)

$(READY): requirements.lock pyproject.toml
	$(require-python)
	@echo "Setting up $(VENV): about a minute, once."
	@$(PYTHON) -m venv --clear $(VENV)
	@$(BIN)/python -m pip install -qq --require-hashes -r requirements.lock
	@$(BIN)/python -m pip install -qq --no-deps --no-build-isolation -e .
	@touch $@

# Pins stay as they are where they still fit; delete requirements.lock first to take the newest of everything.
lock:
	$(require-python)
	@$(PYTHON) -m venv .venv-lock
	@.venv-lock/bin/python -m pip install -qq "uv>=0.9,<1"
	@.venv-lock/bin/uv pip compile --quiet --universal --python-version 3.11 --generate-hashes \
		--extra test --group build --custom-compile-command "make lock" -o requirements.lock pyproject.toml

clean:
	@rm -rf $(VENV) .venv-lock $(DEMO) $(DEMO_DIAGNOSIS) .pytest_cache .ruff_cache .hypothesis
	@rmdir out 2>/dev/null || true
	@find jaxstick fitting tests scripts -type d -name __pycache__ -prune -exec rm -rf {} + 2>/dev/null || true

define require-python
@command -v $(PYTHON) >/dev/null || { echo "jaxstick needs Python 3.11 or newer, but there is no '$(PYTHON)' here; name one with: make PYTHON=/path/to/python3" >&2; exit 2; }
@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { echo "jaxstick needs Python 3.11 or newer, but '$(PYTHON)' is $$($(PYTHON) -V 2>&1); name a newer one with: make PYTHON=/path/to/python3" >&2; exit 2; }
@$(PYTHON) -c 'import ensurepip, venv' 2>/dev/null || { echo "'$(PYTHON)' cannot make virtual environments because its ensurepip module is missing; on Debian and Ubuntu install it with: apt-get install python3-venv" >&2; exit 2; }
endef
