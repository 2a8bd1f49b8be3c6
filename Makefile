# With Python 3.11 on the machine: `make demo` runs the main job, `make test` passes the tests.

VENV   := .venv
BIN    := $(VENV)/bin
STAMP  := $(VENV)/installed
NEEDED := Python 3.11 is needed and was not found: install it, or say where it is with `make PYTHON=PATH`

# The first of these that is Python 3.11; nothing where none is.
RIGHT_PYTHON = $(shell for python in $(or $(PYTHON),python3.11 python3 python); do \
	$$python -c 'import sys; sys.exit(sys.version_info[:2] != (3, 11))' 2>/dev/null && echo $$python && break; done)

.PHONY: demo score test lint check-tests install clean \
	soak soak-diff soak-domains soak-experts soak-fuzz soak-grasp soak-kill soak-one-shot soak-plan
.DEFAULT_GOAL := demo

demo: install
	$(BIN)/ntp demo

test: lint check-tests

lint: install
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/ntp fmt --check examples/* ntp_dsl/library

check-tests: install
	OMP_NUM_THREADS=1 $(BIN)/pytest -n 2 -q

# How much of the flawed corpus is caught, located and fixed.
score: install
	@$(BIN)/python tests/corpus/score.py

# What `make test` runs a few of, in the numbers that the measured figures were made with.
soak: soak-experts soak-domains soak-one-shot soak-diff soak-kill soak-fuzz soak-grasp soak-plan

soak-one-shot: install
	$(BIN)/pytest -n 2 -q --soak tests/evaluation/test_one_shot.py

soak-domains: install
	$(BIN)/pytest -q --soak tests/evaluation/test_domain_figures.py tests/evaluation/test_other_domains.py

soak-experts: install
	$(BIN)/pytest -n 2 -q --soak tests/experts

soak-fuzz: install
	$(BIN)/pytest -n 2 -q --soak tests/language/test_fuzz.py tests/language/test_session.py

soak-grasp: install
	$(BIN)/pytest -n 2 -q --soak tests/kinematics/test_execution_figures.py tests/kinematics/test_shapes.py

soak-plan: install
	$(BIN)/pytest -n 2 -q --soak tests/kinematics/test_planning_figures.py tests/kinematics/test_checker.py

soak-diff: install
	$(BIN)/pytest -n 2 -q --soak tests/traces/test_divergence.py

soak-kill: install
	$(BIN)/pytest -n 2 -q --soak tests/traces/test_kill.py

# The stamp holds what was installed by, so that nothing is installed twice.
install: $(BIN)/python
	@cat pyproject.toml constraints.txt | cmp -s - $(STAMP) || { \
		$(BIN)/python -m pip install --quiet -c constraints.txt -e ".[test,viz]" && \
		cat pyproject.toml constraints.txt > $(STAMP); }

$(BIN)/python:
	$(if $(RIGHT_PYTHON),,$(error $(NEEDED)))
	$(RIGHT_PYTHON) -m venv $(VENV)

clean:
	rm -rf $(VENV) dist .pytest_cache .mypy_cache .ruff_cache .hypothesis
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
