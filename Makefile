# make demo | test | test-all | firmware-test | wheel | lint | bench | docs | rivals | peers | lock | clean; each sets up .venv first (half a minute, once)

PYTHON ?= $(shell python3.11 -c '' 2>/dev/null && echo python3.11 || echo python3)
WORKERS ?= auto
BIN := .venv/bin
READY := .venv/.ready
INSTALL := $(BIN)/uv pip install --quiet --python $(BIN)/python

.PHONY: demo test test-all firmware-test wheel lint bench docs pages rivals peers lock clean python
.DELETE_ON_ERROR:

demo: $(READY)
	@$(BIN)/rwjax diagnose data/demo/rig.toml data/demo/*.csv -o build/demo

test: $(READY)
	@$(BIN)/python -m rwjax.effects.table
	@$(BIN)/python -m pytest -n $(WORKERS) --maxprocesses 8 --dist worksteal -m "not slow" $(ARGS)

# Those too that take long, most of them for compiling: every effect's numbers recovered, every effect's own cases.
# Every call of a function is checked against its signature then (tests/type_checks.py).
test-all: $(READY)
	@RWJAX_EVERY_CALL=1 $(BIN)/python -m pytest -n $(WORKERS) --maxprocesses 8 --dist worksteal $(ARGS)

# The firmware for both boards, and its tests in the simulator; installs nothing: says which Debian packages are missing.
firmware-test: $(READY)
	@$(BIN)/python -m firmware.simavr.avr
	@$(MAKE) -s -C firmware
	@RWJAX_FIRMWARE=required $(BIN)/python -m pytest -n $(WORKERS) --maxprocesses 8 --dist worksteal tests/firmware tests/link \
		tests/planning/test_experiment.py $(ARGS)

# The package as a user gets it: built, and tried with the newest Python from 3.11 to 3.14 here that is not that of .venv.
wheel: $(READY)
	@.ci/wheel

lint: $(READY)
	@$(BIN)/ruff check .
	@$(BIN)/ruff format --check .
	@$(BIN)/pyright
	@$(BIN)/lint-imports --no-logo --no-cache

# The benchmark of the fit against its rivals and a C program (half an hour; gcc); PARTS="contenders" for one table.
bench: .venv/.bench
	@$(BIN)/python -m experiments.speed.run $(PARTS)

.venv/.bench: $(READY)
	@$(INSTALL) --no-build-isolation -e ".[bench]"
	@touch $@

# The pages of docs/ as a site in build/docs: notebooks are executed, and a warning ends it. `make pages` leaves the gallery of effects out,
# and what the notebooks print: that takes a minute.
docs: .venv/.docs
	@$(BIN)/python docs/gallery.py
	@$(MAKE) -s pages EXECUTED=force

EXECUTED ?= off
pages: .venv/.docs
	@$(BIN)/sphinx-build -q -W --keep-going -b html -D nb_execution_mode=$(EXECUTED) docs build/docs
	@echo "build/docs/index.html"

.venv/.docs: $(READY) docs/requirements.lock
	@$(INSTALL) --require-hashes --no-deps -r docs/requirements.lock
	@touch $@

# Rivals of the diagnosis on labelled cases of the separate simulator (half a minute a case), then their scores.
rivals: .venv/.rivals
	@$(BIN)/python -m experiments.rivals.run explore --limit 30 -o build/rivals.jsonl
	@$(BIN)/python -m experiments.rivals.score build/rivals.jsonl --coverage 0.95

.venv/.rivals: $(READY)
	@$(INSTALL) --no-build-isolation -e ".[rivals]"
	@touch $@

# Other tools on the same measured logs (minutes). jax-sysid wants a JAX of its own.
peers: .venv/.peers build/peers/jax-sysid
	@$(BIN)/python -m experiments.peers.run

build/peers/jax-sysid:
	@$(PYTHON) -m venv $@
	@$@/bin/python -m pip install -q --disable-pip-version-check "jax-sysid>=1.1"

.venv/.peers: $(READY)
	@$(INSTALL) --no-build-isolation -e ".[peers]"
	@touch $@

# The locked files, by their hashes: first uv, which fetches the others; then the package itself as it lies here, with nothing else resolved.
$(READY): requirements.lock pyproject.toml | python
	@echo "setting up .venv (1.3 GB; half a minute or a few minutes the first time)"
	@$(PYTHON) -m venv .venv
	@sed -n '/^uv==/,/[^\\]$$/p' requirements.lock >.venv/uv.lock
	@$(BIN)/python -m pip install -q --disable-pip-version-check --require-hashes -r .venv/uv.lock
	@$(INSTALL) --require-hashes -r requirements.lock
	@$(INSTALL) --no-deps --no-build-isolation -e .
	@touch $@

python:
	@$(PYTHON) -c '' 2>/dev/null || { echo "rwjax needs Python 3.11 to 3.14; '$(PYTHON)' does not run: try make PYTHON=/path/to/python3.11" >&2; exit 1; }
	@$(PYTHON) -c 'import sys; v = sys.version_info; (3, 11) <= v < (3, 15) or sys.exit(f"rwjax needs Python 3.11 to 3.14; $(PYTHON) is {v[0]}.{v[1]}: try make PYTHON=/path/to/python3.11")'
	@$(PYTHON) -c 'import ensurepip, venv' 2>/dev/null || { echo "rwjax needs Python's venv module: apt-get install python3-venv" >&2; exit 1; }

# For maintainers: newest versions that pyproject.toml allows, for Python 3.11 on 64-bit Linux; they have wheels up to 3.14.
lock: | python
	@$(PYTHON) -m venv build/lock
	@build/lock/bin/python -m pip install -q --disable-pip-version-check uv
	@build/lock/bin/uv pip compile --quiet --no-config --upgrade --generate-hashes --extra dev --extra experiments --extra data --extra link --extra mujoco --extra fleet \
		--python-version 3.11 --python-platform x86_64-manylinux_2_28 \
		--custom-compile-command "make lock" -o requirements.lock pyproject.toml
	@build/lock/bin/uv pip compile --quiet --no-config --upgrade --generate-hashes --extra docs --constraint requirements.lock \
		--python-version 3.11 --python-platform x86_64-manylinux_2_28 \
		--custom-compile-command "make lock" -o docs/requirements.lock pyproject.toml

clean:
	rm -rf .venv build dist docs/_generated .pytest_cache .ruff_cache .hypothesis
	find rwjax tests -name __pycache__ -type d -prune -exec rm -rf {} +
