# Everything runs from two commands on a machine with Python 3.10 to 3.13: `make eval` and `make test`.
SHELL := /bin/bash
.SHELLFLAGS := -euo pipefail -c
.DEFAULT_GOAL := help

VENV   := .venv
PY     := $(VENV)/bin/python
# Stamps: installed what the package needs (CORE), and what the tests need in addition (STAMP).
CORE   := $(VENV)/.core
STAMP  := $(VENV)/.installed
WARM   := $(VENV)/.warm
# The newest interpreter that PyBullet has wheels for, else a newer one; it must really start (a version manager's shim
# may not). Without PyBullet, shipped homes can be played and trained on, but no home or episode set can be made.
PYTHON ?= $(shell for p in python3.11 python3.10 python3.12 python3.13 python3 python; do \
	$$p -c 'import sys; sys.exit(not (3, 10) <= sys.version_info[:2] <= (3, 13))' >/dev/null 2>&1 && { echo $$p; break; }; done)
INSTALL = $(PY) -m pip install --quiet --disable-pip-version-check --no-compile --constraint constraints.txt
# Without stored bytecode every command compiles its libraries again: 3 s for torch, 5 s for TorchRL.
unexport PYTHONDONTWRITEBYTECODE
# Number of tests that run at once; tests with a time limit run alone, after the others.
JOBS   ?= 2
TOGETHER = OMP_NUM_THREADS=1 $(PY) -m pytest -n $(JOBS) --dist worksteal

.PHONY: help setup eval test test-fast test-slow test-offline mutants docs lint format clean

help: ## List the targets.
	@grep -hE '^[a-z-]+:.*## ' $(MAKEFILE_LIST) | sed -E 's/:.*## /\t/' | expand -t 12

setup: $(STAMP) $(WARM) ## Make .venv, install the pinned set, compile the kernels. Does nothing when done.

$(PY):
	@if [ -z "$(PYTHON)" ]; then echo "Python 3.10 to 3.13 is needed; install one, or name it: make setup PYTHON=/path/to/python3.11" >&2; exit 2; fi
	@echo "making $(VENV) with $(PYTHON)"
	@$(PYTHON) -m venv $(VENV)

$(CORE): pyproject.toml constraints.txt | $(PY)
	$(INSTALL) --editable '.[serve]'
	@$(PY) -c 'import sys; sys.version_info >= (3, 12) and print("PyBullet has no wheels for this Python: shipped homes and sets can be played and trained on, new ones cannot be made here")'
	@touch $@

$(STAMP): $(CORE)
	$(INSTALL) --editable '.[dev]'
	@touch $@

$(WARM): $(CORE)
	$(PY) -m ucon doctor --warm
	@touch $@

eval: $(WARM) ## Evaluate the `belief` agent with retrieved habits on 50 episodes; show one search without and with habits.
	$(PY) eval.py agent=belief habit_level=retrieval episodes=mini
	$(PY) -m ucon demo

test: setup ## Run the tests (some 20 minutes).
	$(TOGETHER) -m 'not slow and not timed'
	$(PY) -m pytest -m 'timed and not slow'

#: A quick sample of tests from all parts.
SPINE = tests/core tests/habits tests/task tests/retrieval tests/sim tests/test_configs.py tests/test_readme.py \
  tests/perception/test_semantic_map.py tests/perception/test_belief.py \
  tests/envs/test_ucon_env.py tests/envs/test_ends.py tests/envs/test_frame.py tests/commands/test_help_page.py \
  tests/evaluation/test_metrics.py tests/evaluation/test_report.py tests/evaluation/test_record.py \
  tests/evaluation/test_runner.py tests/models/test_defaults.py tests/models/test_choosing.py \
  tests/learning/test_plan.py tests/learning/test_checkpoints.py

test-fast: setup ## Run a spine through all parts (under two minutes).
	$(TOGETHER) -m 'not slow and not timed' $(SPINE)

test-slow: setup ## Run the long checks too.
	$(TOGETHER) -m 'not timed'
	$(PY) -m pytest -m timed

#: Attempts to reach another machine, by whichever Python; the tests of the watch itself make a few on purpose.
ASKED = $(CURDIR)/build/asked.log
test-offline: setup ## Run the tests where there is no network (Linux); list what was asked of other machines.
	@mkdir -p build && rm -f $(ASKED)
	HF_HUB_OFFLINE=1 UCON_NETWORK_LOG=$(ASKED) PYTHONPATH=$(CURDIR):$(CURDIR)/tests/network_watch \
	  unshare -rn sh -c 'ip link set lo up && $(TOGETHER) -m "not slow and not timed" --ignore=tests/cluster'
	@if [ -s $(ASKED) ]; then echo "asked of other machines:"; cat $(ASKED); fi

$(VENV)/.mutants: $(STAMP)
	$(INSTALL) --editable '.[dev,mutants]'
	@touch $@

mutants: setup $(VENV)/.mutants ## Mutate the code in 150 places and see whether tests notice (hours; resumes).
	OMP_NUM_THREADS=1 $(PY) -m tests.mutants --jobs $(JOBS)

$(VENV)/.docs: $(STAMP)
	$(INSTALL) --editable '.[docs]'
	@touch $@

docs: setup $(VENV)/.docs ## Build the pages of docs/ into build/site.
	NO_MKDOCS_2_WARNING=1 $(VENV)/bin/mkdocs build --strict

lint: setup ## ruff and mypy.
	$(VENV)/bin/ruff check .
	$(VENV)/bin/ruff format --check .
	$(VENV)/bin/mypy ucon models train.py eval.py

format: setup ## Fix and format with ruff.
	$(VENV)/bin/ruff check --fix .
	$(VENV)/bin/ruff format .

clean: ## Remove caches and build folders (not .venv, not runs/).
	rm -rf build dist .pytest_cache .mypy_cache .ruff_cache
	find . -name __pycache__ -not -path './$(VENV)/*' -prune -exec rm -rf {} +
