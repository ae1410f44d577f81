# Two commands need only Python, make and the package registries:
#   make demo    sets everything up and runs the main job
#   make test    sets everything up and checks everything
PYTHON ?= python3
VENV ?= .venv
BIN := $(VENV)/bin
STAMP := $(VENV)/.installed

.PHONY: demo test lint types unit docs generate check-generated bench clean

$(STAMP): pyproject.toml
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --upgrade pip
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable ".[robots,dev]"
	touch $@

demo: $(STAMP)
	$(BIN)/nao-kin info
	$(BIN)/nao-kin fk --posture StandInit --deg
	$(BIN)/python scripts/forward_kinematics.py --frame LArm --frame LLeg --frame CameraTop
	$(BIN)/nao-kin view --posture StandInit --html nao.html

test: lint types check-generated docs unit

lint: $(STAMP)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

types: $(STAMP)
	$(BIN)/mypy

unit: $(STAMP)
	@command -v check_urdf >/dev/null || echo "check_urdf is absent (Debian: liburdfdom-tools); its tests are skipped"
	@command -v chromium chromium-browser google-chrome >/dev/null || echo "no Chromium; the browser tests are skipped"
	$(BIN)/pytest -n auto --dist loadfile

docs: $(STAMP)
	$(BIN)/sphinx-build -W --keep-going -q -b html docs docs/_build/html

generate: $(STAMP)
	$(BIN)/python scripts/generate_meshes.py
	$(BIN)/python scripts/generate_urdf.py
	$(BIN)/python scripts/generate_joint_diagram.py

check-generated: $(STAMP)
	$(BIN)/python scripts/generate_meshes.py --check
	$(BIN)/python scripts/generate_urdf.py --check
	$(BIN)/python scripts/generate_joint_diagram.py --check

bench: $(STAMP)
	$(BIN)/python benchmarks/bench_fk.py
	$(BIN)/python benchmarks/bench_rotations.py
	$(BIN)/python benchmarks/bench_viewer.py

clean:
	rm -rf $(VENV) docs/_build build dist .mypy_cache .pytest_cache .ruff_cache .hypothesis
