# Needs only python3 (>= 3.11) and make. `make demo` and `make test` are the two commands of the README.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
DEMO := demo
LIBRARY := service/page/library
# Bytecode is stored as modules are loaded; pip would compile all of it, on one core.
unexport PYTHONDONTWRITEBYTECODE
# The lock files name every dependency, so pip need not look for any.
PIP := $(BIN)/python -m pip install --quiet --disable-pip-version-check --no-compile --no-deps

.DEFAULT_GOAL := help
.PHONY: help install install-dev bytecode install-bench demo warm test test-kernels night night-tests mutants lint docs docs-figures docs-designs bench fuzz contract faults chance kernels dist lock audit clean

help: ## this list
	@grep -hE '^[a-z-]+:.*##' $(MAKEFILE_LIST) | sed -E 's/:.*## /\t/' | expand -t 16

install: $(VENV)/.installed ## the environment in .venv and the command .venv/bin/damperlab

$(VENV)/bin/python:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11) and "Python 3.11 or newer is needed; name one: make PYTHON=python3.12 ...")'
	@$(PYTHON) -m venv $(VENV) || { rm -rf $(VENV); echo "python3 has no venv module; on Debian: apt install python3-venv" >&2; exit 1; }

$(VENV)/.installed: requirements.lock pyproject.toml | $(VENV)/bin/python
	$(PIP) --require-hashes -r requirements.lock
	$(PIP) --no-build-isolation -e .
	@touch $@

install-dev: $(VENV)/.installed-dev node_modules/.installed

node_modules/.installed: package-lock.json
	@if command -v npm >/dev/null; then npm ci --silent --no-audit --no-fund && mkdir -p $(LIBRARY) && cp node_modules/plotly.js-cartesian-dist-min/*.min.js $(LIBRARY) || echo "npm could not install what the page needs" >&2; else echo "no npm here: the page's JavaScript is not checked, and it loads the whole plotting library" >&2; fi
	@mkdir -p $(@D) && touch $@

# What requirements.lock does not name can be installed beside it; a package that it names for other systems comes after both.
$(VENV)/.installed-beside: requirements-dev.lock requirements.lock | $(VENV)/bin/python
	@awk 'NR == FNR {has[$$1]; next} /^[^ ]/ {lacks = !($$1 in has)} lacks' requirements.lock $< >$(VENV)/beside.lock
	$(PIP) --require-hashes -r $(VENV)/beside.lock
	@touch $@

$(VENV)/.installed-dev: requirements-dev.lock $(VENV)/.installed $(VENV)/.installed-beside
	$(PIP) --require-hashes -r $<
	@touch $@

# Hundreds of processes load the package: none shall compile its modules first.
bytecode: install
	@$(BIN)/python -m compileall -q service studies worker src/damperlab

demo: install ## Figure 11 of the paper: computed, stored, its optimum in words, drawn to demo/figure-11.png
	$(BIN)/damperlab run figure-11 --data-dir $(DEMO)/data
	$(BIN)/damperlab optimum figure-11 --data-dir $(DEMO)/data --exclude-locked --top 1
	$(BIN)/damperlab map figure-11 --data-dir $(DEMO)/data -o $(DEMO)/figure-11.png

warm: install bytecode ## every kernel, compiled on every core; at once where that is done
	$(BIN)/damperlab warm --all

# Kernels first, so that no test waits for a compiler: those of tests/kernels.py, at night all. Files in the order of tests/conftest.py, not by their number of tests. Tests
# wait for servers, browsers and clocks for a third of their time: two processes more than there are cores keep the cores busy.
PARALLEL := -n $$($(BIN)/python -c 'import os; print(min(8, 2 + len(os.sched_getaffinity(0))))') --dist loadfile --no-loadscope-reorder

test: install-dev test-kernels ## what guards a change: every test that is not left to the night
	$(BIN)/python -m pytest -m "not night" $(PARALLEL)

test-kernels: install bytecode
	$(BIN)/python -m tests.kernels

night: night-tests mutants faults ## what repeats it longer, wider or end to end: the tests of the night, mutants and the campaigns; `make -k night` goes on after a part that fails
night-tests: install-dev warm
	@date -u +'tests of the night, %FT%TZ'
	$(BIN)/python -m pytest -m night -v $(PARALLEL)

mutants: install-dev ## small mistakes in a copy of the sources, each of which a test must find
	$(BIN)/python -m tests.mutants

lint: install-dev docs ## style, types, layers, documentation
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports
	$(BIN)/python -m tests.durations
	@if [ -x node_modules/.bin/tsc ]; then node_modules/.bin/tsc; elif [ -n "$$CI" ]; then echo "npm is needed to check the page" >&2; exit 1; fi

docs: install-dev ## the documentation site, in site/; a broken link is an error
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --strict

docs-figures: install-dev ## all that the documentation shows of running code, computed again: figures, printed answers, Python, notebooks, the report on the paper, screenshots
	$(BIN)/python -m docs.drawing
	$(BIN)/python -m docs.console
	$(BIN)/python -m docs.snippets
	$(BIN)/python -m docs.demo
	$(BIN)/python -m docs.executed
	$(BIN)/python -m docs.reproduced
	$(BIN)/python -m docs.screens

docs-designs: install-dev ## the named specifications designed again, and their page written
	$(BIN)/python -m docs.designs

install-bench: $(VENV)/.installed-bench

$(VENV)/.installed-bench: requirements-bench.lock $(VENV)/.installed-dev
	$(PIP) --require-hashes -r requirements-bench.lock
	@touch $@

bench: install-bench ## run time and error of the kernels beside other methods, and the share of time spent in kernels
	$(BIN)/python -m tests.benchmarks

fuzz: install-bench ## requests that the OpenAPI document allows or forbids (CASES for each operation), and 20,000 malformed ones over raw sockets
	$(BIN)/python -m tests.fuzz --cases $(or $(CASES),100)
	MALFORMED_REQUESTS=20000 $(BIN)/python -m pytest -q tests/service/security/test_malformed.py

contract: install-dev ## what clients rely on in /openapi.json, renewed; a change that breaks them is refused
	$(BIN)/python -m tests.service.contract

faults: install-dev ## 200 times SIGKILL to workers, scheduler, service; as many with PostgreSQL and S3, servers too; 10,000 reads beside writers; 1,000 flipped bits, every file lost once, the same by commands and over HTTP; 50 faults of hosts, links and strangers (as root)
	$(BIN)/python -m tests.faults.campaign --kills 200
	$(BIN)/python -m tests.faults.campaign --kills 200 --seed 2 --postgresql --s3
	$(BIN)/python -m tests.faults.network --faults 50
	$(BIN)/python -m tests.faults.reading --reads 10000
	$(BIN)/python -m tests.faults.damage --flips 1000
	$(BIN)/python -m tests.faults.doors --commands 200 --http 100
	FAULTS_LOCK_SECONDS=30 $(BIN)/python -m pytest -q tests/service/test_storage_trouble.py

# one run is what `make test` does, so that all of it takes a night: RUNS, BUSY and TESTS make it shorter
chance: install-dev warm ## every test RUNS times (20) beside BUSY busy processes (8), or those that TESTS names: what fails by chance
	$(BIN)/python -m tests.chance --runs $(or $(RUNS),20) --busy $(or $(BUSY),8) -n 4 --dist loadfile --no-loadscope-reorder $(TESTS)

kernels: install ## the kernels of every scene, compiled into the package, so that a wheel answers at once
	$(BIN)/python -m damperlab.worker.shipping

dist: kernels node_modules/.installed ## the wheel and the source archive, with kernels, in dist/
	rm -rf build dist
	$(BIN)/python -c "from setuptools import build_meta as b; b.build_sdist('dist'); b.build_wheel('dist')" >/dev/null

lock: ## renew the lock files (needs uv); names and hashes only
	uv pip compile pyproject.toml --extra build --extra service --universal --python-version 3.11 --generate-hashes \
	    --no-emit-index-url --no-emit-find-links --no-header --no-annotate -o requirements.lock
	uv pip compile pyproject.toml --extra build --extra service --extra pdf --extra postgresql --extra s3 -c requirements.lock --universal --python-version 3.11 \
	    --generate-hashes --no-emit-index-url --no-emit-find-links --no-header --no-annotate -o requirements-image.lock
	uv pip compile pyproject.toml --extra build --extra service --extra pdf --extra postgresql --extra s3 --extra docs --extra dev -c requirements.lock --universal --python-version 3.11 \
	    --generate-hashes --no-emit-index-url --no-emit-find-links --no-header --no-annotate -o requirements-dev.lock
	uv pip compile pyproject.toml --extra service --extra bench -c requirements-dev.lock --universal --python-version 3.11 \
	    --generate-hashes --no-emit-index-url --no-emit-find-links --no-header --no-annotate -o requirements-bench.lock

audit: ## known vulnerabilities of what the lock files name (needs pip-audit and the network)
	pip-audit --disable-pip --require-hashes -r requirements.lock
	pip-audit --disable-pip --require-hashes -r requirements-dev.lock

clean: ## what the commands above made, and nothing else
	rm -rf $(VENV) $(DEMO) site build dist worker/kernels node_modules $(LIBRARY) *.egg-info .pytest_cache .mypy_cache .ruff_cache .import_linter_cache
