# Every target sets up what it needs; nothing is installed outside this folder.
PYTHON ?= python3
BIN := .venv/bin
INSTALLED := .venv/installed
DOCS_INSTALLED := .venv/installed-docs
MUTATION_INSTALLED := .venv/installed-mutation
SPEEDS := $(addprefix benchmarks/,learning.py planning.py compare.py measuring.py)
MEASUREMENTS := $(filter-out $(SPEEDS) benchmarks/mutants.py,$(wildcard benchmarks/*.py))

# Threads make the many small matrix products slower.
export OMP_NUM_THREADS ?= 1
export OPENBLAS_NUM_THREADS ?= 1
export MKL_NUM_THREADS ?= 1

.PHONY: help venv demo test lint types main-job mutants bench measure docs clean

help:
	@echo "make demo    learn pouring, plan a new scene, write the trajectory with plots and a recording to out/demo/"
	@echo "make test    lint, types and all tests"
	@echo "make main-job PYTHON=python3.13"
	@echo "             install for that Python alone, then learn, show, plan and add, in a folder that is removed again"
	@echo "make mutants plant faults in the code and count how many the tests find; takes an hour (EACH=75 a room, SEED=0)"
	@echo "make bench   print the measured speeds, and what became slower"
	@echo "make measure print the other measurements that the documentation reports; takes hours"
	@echo "make docs    build the documentation into docs/_build/html/"
	@echo "make venv    set up the virtual environment .venv (the other targets do it when needed)"
	@echo "make clean   remove what was built, and the virtual environment"

venv: $(INSTALLED)

$(INSTALLED): pyproject.toml
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
		{ echo "Python 3.11 or later is needed: make PYTHON=/path/to/python3.11"; exit 1; }
	@test -x $(BIN)/python || $(PYTHON) -m venv .venv || \
		{ rm -rf .venv; echo "$(PYTHON) cannot make virtual environments; on Debian: apt install python3-venv"; exit 1; }
	$(BIN)/python -m pip install --quiet --upgrade "pip>=25.1"
	$(BIN)/python -m pip install --quiet --editable . --group dev
	@touch $@

$(DOCS_INSTALLED): $(INSTALLED)
	$(BIN)/python -m pip install --quiet --group docs
	@touch $@

$(MUTATION_INSTALLED): $(INSTALLED)
	$(BIN)/python -m pip install --quiet --group mutation
	@touch $@

demo: $(INSTALLED)
	$(BIN)/sbam demo

test: lint types
	$(BIN)/pytest -n 2

lint: $(INSTALLED)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

types: $(INSTALLED)
	$(BIN)/basedpyright

main-job: $(INSTALLED)
	.ci/main_job $(PYTHON)

mutants: $(MUTATION_INSTALLED)
	rm -rf mutants
	$(BIN)/python benchmarks/mutants.py --each $(or $(EACH),75) --seed $(or $(SEED),0)

bench: $(INSTALLED)
	$(BIN)/python benchmarks/learning.py
	$(BIN)/python benchmarks/planning.py
	$(BIN)/python benchmarks/compare.py

measure: $(INSTALLED)
	@for script in $(MEASUREMENTS); do echo "== $$script"; $(BIN)/python $$script || exit 1; done

docs: $(DOCS_INSTALLED)
	$(BIN)/sphinx-build -W --keep-going -q -b html docs docs/_build/html
	@echo "open docs/_build/html/index.html"

clean:
	rm -rf .venv build dist mutants docs/_build .pytest_cache .ruff_cache .hypothesis
