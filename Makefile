# With Python 3.11 on the machine: `make demo` runs the main job, `make test` passes the tests.

VENV   := .venv
BIN    := $(VENV)/bin
STAMP  := $(VENV)/installed
NEEDED := Python 3.11 is needed and was not found: install it, or say where it is with `make PYTHON=PATH`

# The first of these that is Python 3.11; nothing where none is.
RIGHT_PYTHON = $(shell for python in $(or $(PYTHON),python3.11 python3 python); do \
	$$python -c 'import sys; sys.exit(sys.version_info[:2] != (3, 11))' 2>/dev/null && echo $$python && break; done)

# Where `make test-pythons` looks for interpreters; one environment a version.
PYTHONS := $(foreach minor,11 12 13 14,python3.$(minor)) $(wildcard $(HOME)/.pyenv/versions/*/bin/python3)
WITHOUT_TORCH := sim,arm,test

.PHONY: demo score test test-pythons lint check-tests install clean \
	soak soak-core soak-diff soak-domains soak-experts soak-fuzz soak-grasp soak-kill soak-one-shot soak-plan soak-soup
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

# On every Python from 3.11 that is found, what needs no torch (its default build brings gigabytes of GPU libraries)
# and, where PyBullet has no wheels, no PyBullet either. The output says what was left out.
test-pythons:
	@tested=; for python in $(PYTHONS); do \
		version=$$($$python -c 'import sys; v = sys.version_info; print(f"{v[0]}.{v[1]}" if v >= (3, 11) else "")' 2>/dev/null); \
		case " $$tested " in *" $$version "*) continue;; esac; \
		tested="$$tested $$version"; venv=.venvs/$$version; \
		echo "== Python $$version"; \
		{ test -x $$venv/bin/python || $$python -m venv $$venv; } && \
		$$venv/bin/python -m pip install --quiet -c constraints.txt -e ".[$(WITHOUT_TORCH)]" && \
		OMP_NUM_THREADS=1 $$venv/bin/pytest -q --leave-out-missing || exit 1; \
	done; test -n "$$tested" || { echo "no Python from 3.11 was found: say where with make test-pythons PYTHONS=PATH"; exit 1; }

# How much of the flawed corpus is caught, located and fixed, and what is fixed wrongly.
score: install
	@$(BIN)/python tests/corpus/score.py

# What `make test` runs a few of, in the numbers that the measured figures were made with. The paper's authors'
# task files are read where NTP_VAT_DATA says, or beside the checkout.
NTP_VAT_DATA ?= $(abspath $(wildcard ../shared/data/vat))
SOAK := NTP_VAT_DATA="$(NTP_VAT_DATA)" $(BIN)/pytest -q --soak

soak: soak-core soak-experts soak-domains soak-one-shot soak-diff soak-kill soak-fuzz soak-grasp soak-plan soak-soup

soak-core: install
	$(SOAK) -n 2 tests/core --ignore tests/core/per_library

soak-one-shot: install
	$(SOAK) -n 2 tests/evaluation/test_one_shot.py tests/tasks tests/core/per_library/test_checkpoint.py

soak-domains: install
	$(SOAK) tests/evaluation/test_domain_figures.py tests/evaluation/test_other_domains.py

soak-experts: install
	$(SOAK) -n 2 tests/experts

soak-fuzz: install
	$(SOAK) -n 2 tests/language/test_fuzz.py tests/language/test_session.py \
		tests/kinematics/test_arm_files_fuzz.py tests/fuzz

soak-grasp: install
	$(SOAK) -n 2 tests/kinematics/test_execution_figures.py tests/kinematics/test_shapes.py

soak-plan: install
	$(SOAK) -n 2 tests/kinematics/test_planning_figures.py tests/kinematics/test_checker.py

soak-diff: install
	$(SOAK) -n 2 tests/traces/test_divergence.py

soak-kill: install
	$(SOAK) -n 2 tests/traces/test_kill.py

soak-soup: install
	$(SOAK) tests/soup

# The stamp holds what was installed by, so that nothing is installed twice.
install: $(BIN)/python
	@cat pyproject.toml constraints.txt | cmp -s - $(STAMP) || { \
		$(BIN)/python -m pip install --quiet -c constraints.txt -e ".[all,test]" && \
		cat pyproject.toml constraints.txt > $(STAMP); }

$(BIN)/python:
	$(if $(RIGHT_PYTHON),,$(error $(NEEDED)))
	$(RIGHT_PYTHON) -m venv $(VENV)

clean:
	rm -rf $(VENV) .venvs dist .pytest_cache .mypy_cache .ruff_cache .hypothesis
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
