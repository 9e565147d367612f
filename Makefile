# One or two commands each. `make setup` installs what is missing: Debian packages and .venv; a second call does nothing.

export OMP_NUM_THREADS = 1
PYTHON = .venv/bin/python
RANKS = 1
MPIRUN = $(if $(filter-out 1,$(RANKS)),OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 mpirun --oversubscribe -n $(RANKS))
# CalculiX is not in Debian 13, and Ubuntu's Chromium is a snap, which containers cannot run: the tests that need them
# are skipped there. Types are checked with Debian 12's NumPy: the annotations within NumPy 2 say otherwise in 38 places.
OS_RELEASE = /etc/os-release
TRIXIE = $(shell grep trixie $(OS_RELEASE))
UBUNTU = $(shell grep -x ID=ubuntu $(OS_RELEASE))
ABSENT = $(if $(TRIXIE),calculix-ccx) $(if $(UBUNTU),chromium chromium-driver)
PACKAGES = $(filter-out $(ABSENT),$(shell cat apt-packages.txt))
SUDO = $(if $(filter 0,$(shell id -u)),,sudo)

.PHONY: setup benchmark1 benchmark2 outofplane table1 test long quick lint verify bench reference docs clean

setup: .venv/.ready

.venv/.ready: pyproject.toml constraints.txt apt-packages.txt
	dpkg-query -W -f '$${db:Status-Status}\n' $(PACKAGES) 2>&1 | { ! grep -qvx installed; } || \
	    { $(SUDO) apt-get update -q && $(SUDO) env DEBIAN_FRONTEND=noninteractive \
	    apt-get install -y -q --no-install-recommends $(PACKAGES); }
	/usr/bin/python3 -m venv --system-site-packages .venv
	$(PYTHON) -m pip install -q --disable-pip-version-check -c constraints.txt -e '.[fe,test,docs]'
	$(PYTHON) -m pip uninstall -q -y h5py # dolfinx takes Debian's (pyproject.toml)
	$(PYTHON) -c "import numpy, petsc4py.PETSc as p; assert '/.venv/' not in numpy.__file__ and p.ScalarType is numpy.float64"
	touch $@

benchmark1: setup
	$(MPIRUN) $(PYTHON) -m orchestrator run templates/benchmark1.toml --output results/benchmark1 --force

# A facade between two returns, pushed out of its plane: multipliers, pictures, the collapse under a slider.
outofplane: setup
	$(PYTHON) -m orchestrator check templates/uwall.toml --output results/outofplane
	$(PYTHON) -m orchestrator limit templates/uwall.toml --output results/outofplane

# The tolerance studies; a study that was stopped goes on. RANKS=3 shares the runs between two processes, which need not
# yield to each other at every call: on a busy machine that made a study of 18 s last more than 230 s.
STUDYRUN = $(MPIRUN:mpirun=mpirun --mca mpi_yield_when_idle 0)

table1: setup
	$(STUDYRUN) $(PYTHON) -m orchestrator study templates/benchmark1.toml --output results/table1

benchmark2: setup
	$(STUDYRUN) $(PYTHON) -m orchestrator study templates/benchmark2.toml --output results/benchmark2

# Files of tests are shared between WORKERS processes, those that take longest first; all that start ranks are one group
# (tests/conftest.py).
WORKERS = 2
PYTEST = $(PYTHON) -m pytest -n $(WORKERS) --dist loadgroup --no-loadscope-reorder

# All tests but those that take longest by themselves; `make long` has these. CI runs both.
test: lint
	$(PYTEST) -m "not long" tests

long: setup
	$(PYTEST) -m long tests

# The tests that tests/seconds.csv has as fast, of every room: less than a minute on two processors that are free.
quick: setup
	$(PYTEST) -m fast tests

lint: setup
	.venv/bin/ruff check . && .venv/bin/ruff format --check .
	$(if $(TRIXIE)$(UBUNTU),,.venv/bin/mypy &&) .venv/bin/lint-imports

# Heavier studies, some half an hour: the tables in docs/studies.
verify: setup long table1 benchmark2
	HYPOTHESIS_CASES=2000 $(PYTHON) -m pytest -q tests/unit/app/test_bad_input_generated.py
	$(PYTHON) docs/studies/killed.py
	$(PYTHON) docs/studies/killed_benchmark1.py
	$(PYTHON) docs/studies/soak.py
	$(PYTHON) docs/studies/sensitivity.py
	$(PYTHON) docs/studies/cohesion.py
	$(PYTHON) docs/studies/limit_analysis.py
	$(PYTHON) docs/studies/loading_rescues.py
	$(PYTHON) docs/studies/cut_walls.py
	$(PYTHON) docs/studies/structures.py
	$(PYTHON) docs/studies/stiff_stones.py
	$(PYTHON) docs/studies/tolerances.py
	$(PYTHON) docs/studies/benchmark2_seeds.py 1 2
	$(PYTHON) docs/studies/table1.py

# Cost against blocks and ranks, and of benchmark 1: tables and a plot in benchmarks/.
bench: setup
	$(PYTHON) benchmarks/measure.py
	$(PYTHON) benchmarks/limit_analysis.py
	$(PYTHON) benchmarks/facades.py
	$(PYTHON) benchmarks/peers.py

# The stored curves of tests/regression; look at the difference (git diff, build/regression/*.png) before you commit it.
reference: benchmark1
	$(PYTHON) -m orchestrator run templates/benchmark2.toml --output results/benchmark2_run --force
	cp results/benchmark1/case.toml tests/regression/benchmark1/case.toml
	cp results/benchmark2_run/case.toml tests/regression/benchmark2/case.toml
	for model in macro micro; do \
	    cp results/benchmark1/$$model/curve.csv tests/regression/benchmark1/$$model.csv; \
	    cp results/benchmark2_run/$$model/curve.csv tests/regression/benchmark2/$$model.csv; done
	$(PYTHON) -m tests.regression.stored_curves

# build/docs/index.html; warnings are errors.
docs: setup
	NO_MKDOCS_2_WARNING=1 $(PYTHON) -m mkdocs build --strict

clean:
	rm -rf results build *.egg-info .pytest_cache .ruff_cache .mypy_cache .hypothesis
