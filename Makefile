# `make help` lists the commands. They need only Python, make and the package registries.
# What only continuous integration calls is in .ci and .github/workflows.
PYTHON ?= python3
VENV ?= .venv
BIN := $(VENV)/bin
# One more than there are cores, for tests wait for browsers and servers.
WORKERS := $(shell expr $$(nproc 2>/dev/null || echo 2) + 1)
# Empty files that say what is installed: the library alone, with [batch], with [dev], with [dev-full].
PLAIN := $(VENV)/.plain
BATCH := $(VENV)/.batch
DEV := $(VENV)/.dev
FULL := $(VENV)/.dev-full
OPEN := $(if $(filter Darwin,$(shell uname)),open,xdg-open)
PIP_INSTALL := python -m pip install --quiet --disable-pip-version-check --no-compile
# A room, a folder of tests/, or all of them.
TESTS := tests/$(ROOM)
PYTEST := $(BIN)/pytest -n $(WORKERS) --dist loadfile --no-loadscope-reorder $(TESTS)
SPHINX := $(BIN)/sphinx-build -W --keep-going -q -d docs/_build/doctrees
# Bytecode is kept: the tests start hundreds of processes, and each worker reads all tests.
unexport PYTHONDONTWRITEBYTECODE

# There are as many workers as cores; further threads of each would wait for one another.
unit full: export OPENBLAS_NUM_THREADS := 1

.PHONY: help demo test test-all generate docs bench clean
.PHONY: lint types web web-packages unit full bytecode kernels long-kernels other-kernels lowest light check-docs check-generated check-drawn

help: ## these lines
	@awk -F ':.*## ' '/^[a-z-]+:.*## /{printf "make %-9s %s\n", $$1, $$2}' Makefile

demo: $(PLAIN) ## set up the library alone, print poses, and write a page of the robot
	$(BIN)/nao-kin info
	$(BIN)/nao-kin fk --posture StandInit --deg
	$(BIN)/python scripts/forward_kinematics.py --frame LArm --frame LLeg --frame CameraTop
	$(BIN)/nao-kin view --posture StandInit --html nao.html --force
	@echo "Written: $(CURDIR)/nao.html, the robot as a page: open it in a browser, for example with $(OPEN) nao.html"

# At the same time, for none uses both cores all the while; the tests begin when the kernels are compiled.
test: ## set up, and check what a change can break; with ROOM=ik, lint and the tests of tests/ik alone
	$(MAKE) -j4 lint unit $(if $(ROOM),,check-docs types check-generated web)

test-all: $(FULL) ## this, and what takes long: matrices, browsers, notebooks, wheels, drawings, lowest versions
	$(MAKE) test
	$(MAKE) -j4 --output-sync=target full $(if $(ROOM),,check-drawn lowest light)

lint: $(DEV)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

types: $(DEV)
	$(BIN)/mypy

# The page: lint, format, types and tests of its modules, and whether the bundle in nao_kin/viewer/page is built from them.
web: web-packages
	@if command -v npm >/dev/null; then cd web && npm run --silent check; \
	else echo "no npm; the page's modules are not checked"; fi

web-packages:
	@if command -v npm >/dev/null && ! test web/node_modules/.installed -nt web/package-lock.json; then \
	  cd web && npm ci --silent --no-audit --no-fund && touch node_modules/.installed; fi

unit: $(DEV) kernels bytecode $(if $(wildcard $(FULL)),web-packages)
	@command -v check_urdf >/dev/null || echo "check_urdf is absent (Debian: liburdfdom-tools); its tests are skipped"
	@test -f $(FULL) || echo "only [dev] is installed; tests that need more, such as a browser, are skipped: see CONTRIBUTING.md"
	$(PYTEST) -m "not full"

full: $(FULL) kernels web-packages
	$(PYTEST) -m full

# Once, or each worker would compile all test modules itself.
bytecode: $(DEV)
	@$(BIN)/pytest --collect-only $(TESTS) >/dev/null

kernels: long-kernels other-kernels

# In two processes, for one compiles one kernel at a time, and while pip installs what the tests need besides. To look
# for garbage in syntax trees that are all in use takes 7 % of the time.
LONG := {"ik kernel, bodies", "ik kernel, both legs"}
COMPILE := $(BIN)/python -c 'import gc; from nao_kin import _kernels, warm_up; gc.disable(); warm_up(()); warm_up
long-kernels: $(BATCH)
	@$(COMPILE)($(LONG))'

other-kernels: $(BATCH)
	@$(COMPILE)(_kernels.KERNELS.keys() - $(LONG))'

lowest light:
	.ci/$@

docs: $(DEV) ## the documentation as a site, in docs/_build/html
	$(SPHINX) -b html docs docs/_build/html

# Reads the pages and the docstrings and resolves what they refer to; only writing the pages is left out.
check-docs: $(DEV)
	$(SPHINX) -b dummy docs docs/_build/dummy

generate: $(FULL) web-packages ## all files that are generated: URDFs, meshes, drawings, gallery, bundle of the page
	$(BIN)/python scripts/generate_page_messages.py
	cd web && npm run --silent build
	for script in $(GENERATED) $(DRAWN); do $(BIN)/python scripts/$$script.py || exit 1; done

# The first are checked with every change. The second take minutes: `make test-all` checks whether they draw what is committed.
GENERATED := generate_page_messages generate_urdf generate_joint_diagram generate_room_map generate_gallery
DRAWN := generate_meshes generate_collision_shapes draw_explanations draw_pages

check-generated: $(DEV)
	for script in $(GENERATED); do $(BIN)/python scripts/$$script.py --check || exit 1; done

check-drawn: $(FULL)
	for script in $(DRAWN); do $(BIN)/python scripts/$$script.py --check || exit 1; done

bench: $(FULL) ## benchmarks: ratios to plain Pinocchio and others
	for benchmark in benchmarks/bench_*.py; do $(BIN)/python $$benchmark || exit 1; done

clean: ## remove all that these commands made
	rm -rf $(VENV) .venv-lowest .venv-light .coverage docs/_build build dist web/node_modules .mypy_cache .pytest_cache .ruff_cache .hypothesis

# The library alone, unless more is installed.
$(PLAIN): pyproject.toml
	@test -f $(BATCH) || { $(PYTHON) -m venv $(VENV) && $(BIN)/$(PIP_INSTALL) --upgrade pip && $(BIN)/$(PIP_INSTALL) --editable .; }
	@touch $@

# First what compiles the kernels.
$(BATCH): pyproject.toml
	@test -f $(DEV) || { $(PYTHON) -m venv $(VENV) && $(BIN)/$(PIP_INSTALL) --upgrade pip && $(BIN)/$(PIP_INSTALL) --editable ".[batch]"; }
	@touch $@

$(DEV): pyproject.toml | $(BATCH)
	$(BIN)/$(PIP_INSTALL) --editable ".[$(if $(wildcard $(FULL)),dev-full,dev)]"
	@touch $@

$(FULL): pyproject.toml | $(BATCH)
	$(BIN)/$(PIP_INSTALL) --editable ".[dev-full]"
	@touch $(DEV) $@
