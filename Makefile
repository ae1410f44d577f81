# Two commands need only Python, make and the package registries:
#   make demo    sets everything up and runs the main job
#   make test    sets everything up and checks what a change can break
# And while working:
#   make quick        lint and the fast tests, about a minute; with ROOM=ik, all tests of tests/ik
#   make test-all     what `make test` leaves out, at once: matrices, notebooks, wheels, other versions of the dependencies
#   make test-lowest  the fast tests with the lowest versions of all dependencies that pyproject.toml allows
#   make test-light   the wheel with the default dependencies alone answers, and says what an extra would bring
#   make coverage     all tests with branch coverage, 95 % at least
#   make mutate       faults planted one by one, each of which a test must notice
#   make linkcheck    whether the addresses in the docs answer (needs the network)
#   make generate     meshes, URDFs, drawings, the gallery and the page's bundle anew (needs npm and Chromium)
#   make tools-table  every export in the tool it is meant for, docs/tools.md anew (installs the tools, 6 GB)
#   make bench        ratios to plain Pinocchio and others
PYTHON ?= python3
VENV ?= .venv
BIN := $(VENV)/bin
# One more than there are cores, for tests wait for browsers and servers.
WORKERS := $(shell expr $$(nproc 2>/dev/null || echo 2) + 1)
STAMP := $(VENV)/.installed
PLAIN := $(VENV)/.plain
OPEN := $(if $(filter Darwin,$(shell uname)),open,xdg-open)
LOWEST ?= .venv-lowest
LIGHT ?= .venv-light
PIP_INSTALL := python -m pip install --quiet --disable-pip-version-check --no-compile
# Bytecode is kept: the tests start hundreds of processes, and each worker reads all tests.
unexport PYTHONDONTWRITEBYTECODE
QUICK := -m "not slow and not full" --hypothesis-profile=quick
PARALLEL := -n $(WORKERS) --dist loadfile --no-loadscope-reorder

# There are as many workers as cores; further threads of each would wait for one another.
unit test-full test-lowest quick coverage mutate: export OPENBLAS_NUM_THREADS := 1

.PHONY: demo test test-all test-full quick kernels long-kernels other-kernels lint types web web-packages unit test-lowest test-light coverage mutate docs linkcheck generate check-generated tools-table check-tools-table bench clean

$(STAMP): pyproject.toml
	$(PYTHON) -m venv $(VENV)
	$(BIN)/$(PIP_INSTALL) --upgrade pip
	$(BIN)/$(PIP_INSTALL) --editable ".[dev]"
	touch $@

# The library alone, unless everything is installed already.
$(PLAIN): pyproject.toml
	@test -f $(STAMP) || { $(PYTHON) -m venv $(VENV) && $(BIN)/$(PIP_INSTALL) --upgrade pip && $(BIN)/$(PIP_INSTALL) --editable .; }
	@touch $@

demo: $(PLAIN)
	$(BIN)/nao-kin info
	$(BIN)/nao-kin fk --posture StandInit --deg
	$(BIN)/python scripts/forward_kinematics.py --frame LArm --frame LLeg --frame CameraTop
	$(BIN)/nao-kin view --posture StandInit --html nao.html --force
	@echo "Written: $(CURDIR)/nao.html, the robot as a page: open it in a browser, for example with $(OPEN) nao.html"

# At the same time, for none uses both cores all the while; the tests begin when the kernels are compiled.
test: $(STAMP)
	$(MAKE) lint
	$(MAKE) -j4 unit docs types check-generated web

# At the same time, for the full tests mostly wait for processes and browsers.
test-all: $(STAMP) $(LOWEST)/.installed $(LIGHT)/.installed
	$(MAKE) -j3 --output-sync=target test-full test-lowest test-light

test-full: $(STAMP) kernels
	$(BIN)/pytest $(PARALLEL) -m full

quick: lint kernels
	$(BIN)/pytest $(if $(ROOM),$(PARALLEL) tests/$(ROOM),-n auto $(QUICK))

kernels: long-kernels other-kernels

# In a process of its own, for one process compiles one kernel at a time.
LONG := {"ik kernel, bodies", "ik kernel, both legs"}
long-kernels: $(STAMP)
	@$(BIN)/python -c 'from nao_kin import warm_up; warm_up($(LONG))'

other-kernels: $(STAMP)
	@$(BIN)/python -c 'from nao_kin import _kernels, warm_up; warm_up(()); warm_up(_kernels.KERNELS.keys() - $(LONG))'

lint: $(STAMP)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

types: $(STAMP)
	$(BIN)/mypy

# The page: lint, format, types and tests of its modules, and whether the bundle in nao_kin/viewer/page is built from them.
web: web-packages
	@if command -v npm >/dev/null; then cd web && npm run --silent check; \
	else echo "no npm; the page's modules are not checked"; fi

web-packages:
	@if command -v npm >/dev/null && ! test web/node_modules/.installed -nt web/package-lock.json; then \
	  cd web && npm ci --silent --no-audit --no-fund && touch node_modules/.installed; fi

unit: $(STAMP) kernels web-packages
	@command -v check_urdf >/dev/null || echo "check_urdf is absent (Debian: liburdfdom-tools); its tests are skipped"
	@command -v chromium chromium-browser google-chrome >/dev/null || echo "no Chromium; the browser tests are skipped"
	$(BIN)/pytest $(PARALLEL) -m "not full"

$(LOWEST)/.installed: pyproject.toml scripts/lowest_requirements.py
	$(PYTHON) -m venv $(LOWEST)
	$(LOWEST)/bin/$(PIP_INSTALL) --upgrade pip packaging tomli
	$(LOWEST)/bin/python scripts/lowest_requirements.py > $(LOWEST)/constraints.txt
	$(LOWEST)/bin/$(PIP_INSTALL) --constraint $(LOWEST)/constraints.txt --editable ".[robots,test]"
	touch $@

# One worker, for `make test-all` runs it beside the full tests, and each worker reads all tests.
test-lowest: $(LOWEST)/.installed
	$(LOWEST)/bin/nao-kin warmup >/dev/null
	$(LOWEST)/bin/python -m pytest -n 1 $(QUICK)

$(LIGHT)/.installed: pyproject.toml | $(STAMP)
	$(PYTHON) -m venv $(LIGHT)
	$(BIN)/python -m build --wheel --no-isolation --outdir $(LIGHT)/dist . >/dev/null
	$(LIGHT)/bin/$(PIP_INSTALL) $(LIGHT)/dist/*.whl pytest
	touch $@

# The wheel of now, tried outside of the checkout.
test-light: $(LIGHT)/.installed
	rm -rf $(LIGHT)/dist
	$(BIN)/python -m build --wheel --no-isolation --outdir $(LIGHT)/dist . >/dev/null
	$(LIGHT)/bin/$(PIP_INSTALL) --force-reinstall --no-deps $(LIGHT)/dist/*.whl
	cd $(LIGHT) && bin/python -I -m pytest -q --noconftest -p no:cacheprovider -c /dev/null --rootdir . \
	  $(CURDIR)/tests/project/test_default_install.py

coverage: $(STAMP) kernels
	$(BIN)/pytest -n auto --dist loadfile --cov --cov-report=term --cov-report=html:build/coverage

mutate: $(STAMP)
	$(BIN)/python scripts/mutate.py

docs: $(STAMP)
	$(BIN)/sphinx-build -W --keep-going -q -b html docs docs/_build/html

linkcheck: $(STAMP)
	$(BIN)/sphinx-build -q -b linkcheck docs docs/_build/linkcheck

generate: $(STAMP) web-packages
	$(BIN)/python scripts/generate_page_messages.py
	cd web && npm run --silent build
	$(BIN)/python scripts/generate_meshes.py
	$(BIN)/python scripts/generate_collision_shapes.py
	$(BIN)/python scripts/generate_urdf.py
	$(BIN)/python scripts/generate_joint_diagram.py
	$(BIN)/python scripts/generate_room_map.py
	$(BIN)/python scripts/generate_gallery.py
	$(BIN)/python scripts/draw_explanations.py

check-generated: $(STAMP)
	$(BIN)/python scripts/generate_page_messages.py --check
	$(BIN)/python scripts/generate_meshes.py --check
	$(BIN)/python scripts/generate_collision_shapes.py --check
	$(BIN)/python scripts/generate_urdf.py --check
	$(BIN)/python scripts/generate_joint_diagram.py --check
	$(BIN)/python scripts/generate_room_map.py --check
	$(BIN)/python scripts/generate_gallery.py --check
	$(BIN)/python scripts/draw_explanations.py --check

tools-table: $(STAMP)
	$(BIN)/python scripts/measure_tools.py

check-tools-table: $(STAMP)
	$(BIN)/python scripts/measure_tools.py --check

bench: $(STAMP)
	$(BIN)/python benchmarks/bench_fk.py
	$(BIN)/python benchmarks/bench_rotations.py
	$(BIN)/python benchmarks/bench_rotation_functions.py
	$(BIN)/python benchmarks/bench_screws.py
	$(BIN)/python benchmarks/bench_viewer.py
	$(BIN)/python benchmarks/bench_batch.py
	$(BIN)/python benchmarks/bench_loops.py
	$(BIN)/python benchmarks/bench_stream.py
	$(BIN)/python benchmarks/bench_world.py
	$(BIN)/python benchmarks/bench_reach.py
	$(BIN)/python benchmarks/bench_collisions.py
	$(BIN)/python benchmarks/bench_ik.py
	$(BIN)/python benchmarks/bench_ik_numeric.py
	$(BIN)/python benchmarks/bench_whole_body.py
	$(BIN)/python benchmarks/bench_motion.py
	$(BIN)/python benchmarks/bench_naoqi.py

clean:
	rm -rf $(VENV) $(LOWEST) $(LIGHT) .coverage docs/_build build dist web/node_modules .mypy_cache .pytest_cache .ruff_cache .hypothesis
