# make run     the demo machine mills a plate        make test    every check and test
# make bench   measures                              make lock    new versions of the dependencies
# make test-vm                         the runtime on a PREEMPT_RT kernel with SocketCAN, then as a systemd service, in QEMU (skipped, with
#                                      the reason, where that cannot be); VM=tests/vm/test_socketcan.py: only a part
# make fuzz SECONDS=300                looks for bytes that crash the decoder
# make coverage-spec SPEC=FOLDER       which entries of a catalogue have passing tests; CORE=1,2 GROUPS=1 RESULTS=FILE
#
# Everything lives in .venv; nothing needs root. PYTHON=… chooses another interpreter, 3.11 or later.

SHELL := /bin/bash
.SHELLFLAGS := -euo pipefail -c
.ONESHELL:
.DEFAULT_GOAL := help
.PHONY: help install run test check pytest test-vm coverage-spec fuzz bench lock clean

PYTHON ?=
PYTEST_ARGS ?=
SPEC ?=
RESULTS ?=
CORE ?=
GROUPS ?=
SECONDS ?= 300
VM ?= tests/vm
PARALLEL ?= -n auto --dist loadfile
BIN := .venv/bin
SPEC_RESULTS := out/spec-results.json

# The environment fits as long as this name exists: it changes with the lock, the project file and the folder.
FINGERPRINT := $(shell { cat pyproject.toml requirements.lock; pwd; } | sha256sum | cut -c1-16)
INSTALLED := .venv/installed-$(FINGERPRINT)

help:
	@sed -n 's/^# //p' Makefile | head -7

install: $(INSTALLED)

$(INSTALLED):
	@fits() { "$$1" -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null; }
	if ! fits $(BIN)/python || ! grep -qsF "$$PWD/.venv/" $(BIN)/pip; then
	    rm -rf .venv
	    for python in $(PYTHON) python3 python3.13 python3.12 python3.11 none; do
	        if fits "$$python"; then break; fi
	    done
	    if [ "$$python" = none ]; then
	        echo "Python 3.11 or later is needed (Debian: apt install python3 python3-venv)" >&2; exit 1
	    fi
	    echo "== environment .venv with $$("$$python" --version)"
	    if ! "$$python" -m venv .venv; then
	        rm -rf .venv
	        echo "Python's venv module is needed (Debian: apt install python3-venv)" >&2; exit 1
	    fi
	fi
	echo "== installing the dependencies of requirements.lock"
	rm -f .venv/installed-*
	$(BIN)/python -m pip install --disable-pip-version-check -r requirements.lock
	echo "== installing tandem-cnc"
	$(BIN)/python -m pip install --disable-pip-version-check --quiet --no-deps --editable .
	touch $@

run: $(INSTALLED)
	@$(BIN)/tandem run --demo

test: check pytest

check: $(INSTALLED)
	@echo "== ruff";         $(BIN)/ruff check .
	echo "== ruff format";  $(BIN)/ruff format --check .
	echo "== mypy";         $(BIN)/mypy
	echo "== lint-imports"; $(BIN)/lint-imports

# On all processors, each file on one of them: what its tests share is made once. The kernels as plain Python first; what stands last
# is the sum of everything.
pytest: $(INSTALLED)
	@echo "== pytest, kernels uncompiled"
	NUMBA_DISABLE_JIT=1 $(BIN)/python -m pytest $(PARALLEL) -m uncompiled $(PYTEST_ARGS)
	echo "== pytest"
	$(BIN)/python -m pytest $(PARALLEL) --spec-results=$(SPEC_RESULTS) $(PYTEST_ARGS)

# Runs the tests that name entries, unless RESULTS names what an earlier run wrote (`make test` writes it too).
coverage-spec: $(INSTALLED)
	@if [ -z "$(SPEC)" ]; then echo "SPEC=FOLDER is missing: where the catalogue is" >&2; exit 2; fi
	if [ -z "$(RESULTS)" ]; then
	    $(BIN)/python -m pytest $(PARALLEL) -m spec --spec-results=$(SPEC_RESULTS) $(PYTEST_ARGS) || [ $$? -eq 1 ]
	fi
	$(BIN)/python -m tests.coverage_spec "$(SPEC)" --results "$(or $(RESULTS),$(SPEC_RESULTS))" \
	    $(if $(CORE),--core $(CORE)) $(if $(GROUPS),--groups)

fuzz: $(INSTALLED)
	@$(BIN)/python -m tests.fuzz --seconds $(SECONDS)

test-vm: $(INSTALLED)
	@echo "== virtual machine"
	$(BIN)/python -m pytest $(VM) -n0 -rs $(PYTEST_ARGS)

bench: $(INSTALLED)
	@$(BIN)/python -m bench

lock: $(INSTALLED)
	@$(BIN)/python -m pip install --disable-pip-version-check --quiet pip-tools
	$(BIN)/pip-compile --quiet --upgrade --extra dev --strip-extras --no-header --no-emit-options \
	    --output-file requirements.lock pyproject.toml

clean:
	@rm -rf .venv out build *.egg-info .pytest_cache .mypy_cache .ruff_cache .hypothesis .import_linter_cache
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
