# Two commands set everything up on a fresh machine: `make reproduce` and `make test`. Both make .venv themselves.

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
# Modules are compiled when they are first imported: to compile all of them takes a minute.
PIP_INSTALL := $(BIN)/pip install --quiet --no-compile
# One process more than cores, because tests of serial lines wait; tests/conftest.py distributes them.
PARALLEL = -n $$(($$(nproc) + 1)) --dist loadscope --no-loadscope-reorder

# Tests start more than a hundred processes: each would compile all sources again.
unexport PYTHONDONTWRITEBYTECODE

.PHONY: reproduce test pytest test-baselines test-wheel lint throughput docs docs-linkcheck clean

reproduce: $(VENV)/installed
	$(BIN)/khepera-forage reproduce

# Types are checked while the first tests wait for their programs.
test: $(VENV)/installed
	$(MAKE) --jobs 2 lint pytest

pytest: $(VENV)/installed
	$(BIN)/python -m pytest $(PARALLEL)

# torch first and pinned: a range would take the newest build, with gigabytes of GPU libraries. And without dev, whose
# toio-py wants an older setuptools than torch: pip would exchange torch for such a build.
test-baselines: $(VENV)/installed
	$(PIP_INSTALL) torch==2.13.0
	$(PIP_INSTALL) --editable '.[baselines,dask]'
	$(BIN)/python -m pytest $(PARALLEL) tests/baselines tests/benchmarks/test_learners_on_clusters.py

# Installs the wheel into empty environments, without extras and with each extra.
test-wheel: $(VENV)/installed
	$(BIN)/python -m pytest tests/wheel

lint: $(VENV)/installed
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

throughput: $(VENV)/installed
	$(BIN)/python benchmarks/throughput.py

# The site, in build/docs. Every warning is an error: a broken link, an unknown name, a page outside the tree.
docs: $(VENV)/docs-installed
	$(BIN)/sphinx-build --fail-on-warning --keep-going --jobs auto --builder html docs build/docs
	@echo "build/docs/index.html"

# Links to other sites, which needs a network.
docs-linkcheck: $(VENV)/docs-installed
	$(BIN)/sphinx-build --jobs auto --builder linkcheck docs build/docs-linkcheck

$(VENV)/docs-installed: $(VENV)/installed
	$(PIP_INSTALL) --editable '.[docs]'
	@touch $@

$(VENV)/installed: pyproject.toml
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
		{ echo "Python 3.11 or later is needed; $(PYTHON) is $$($(PYTHON) --version 2>&1). Try make PYTHON=python3.11"; exit 1; }
	@test -x $(BIN)/pip || $(PYTHON) -m venv $(VENV) || \
		{ rm -rf $(VENV); echo "Python's venv is missing: apt install python3-venv"; exit 1; }
	$(PIP_INSTALL) --editable '.[dev]'
	@touch $@

clean:
	rm -rf $(VENV) results build docs/api
