# `make test` and `make benchmark` need Python >= 3.10, pip and make; they set up .venv themselves.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
STAMP := $(VENV)/.installed
# `make PINNED= VENV=build/newest test` tests with the newest version of every package.
PINNED := --constraint constraints.txt

.PHONY: setup test test-nightly quick bits lint format benchmark hours results speed ratios validate notebooks shown pages docs core contract films libraries audit blocks package soak mutations clean

setup: $(STAMP)

$(STAMP): pyproject.toml constraints.txt
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check $(PINNED) --editable '.[dev]'
	touch $(AGENTS) $(STAMP)

# Only the packages that train and judge agents.
AGENTS := $(VENV)/.agents

$(AGENTS): pyproject.toml constraints.txt
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check $(PINNED) --editable '.[agents]'
	touch $(AGENTS)

# Two processes; each collects its own half of the test folders (tests/conftest.py), which saves time.
test: setup
	HALVES=1 $(BIN)/python -m pytest -n 2 --dist each

# More environments, more random cases, and slow tests.
test-nightly: setup
	$(BIN)/python -m pytest -n 2 --dist worksteal -m "nightly or hypothesis" --hypothesis-profile nightly

# The tests of one folder, until the first fails: `make quick FOLDER=process`.
FOLDER ?= control

quick: setup
	$(BIN)/python -m pytest -n 2 --dist worksteal -x tests/$(FOLDER)

# Hostile and random input for every part; each run appends to build/soak/<commit>.jsonl. `make soak PARTS=files`.
MINUTES ?= 60

soak: setup
	$(BIN)/python -m tests.soak --minutes $(MINUTES) $(if $(PARTS),--part $(PARTS))

# Do the tests find one-line mistakes in a copy of the last commit? An interrupted run resumes.
mutations: setup
	$(BIN)/python -m tests.mutations --least 37

# Tests of equal bits on the code paths of other processors; `make bits PATHS=plain-python` runs one path.
bits: setup
	$(BIN)/python -m tests.code_paths $(PATHS)

lint: setup
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

format: setup
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

benchmark: $(AGENTS)
	$(BIN)/python -m agents benchmark

# All results, one study after the other; cached runs are not repeated. `make hours` only prints the hours of each.
RESULTS := 'benchmark --full' replicate gaps splits track safety plants recipe \
	dress-study 'dress-study --program grind_env/examples/plate_g82.nc --parts 30' intervals

hours: $(AGENTS)
	for each in $(RESULTS); do $(BIN)/python -m agents $$each --hours; done | \
		awk '{ print; sum += $$(NF - 1) } END { printf "in all: %.1f core-hours\n", sum }'

results: hours
	set -e; for each in $(RESULTS); do $(BIN)/python -m agents $$each; done

speed: setup
	$(BIN)/python -m tests.speed

# The speed ratios of tests/speed/ratios.toml, in a minute; fails if a ratio is outside its tolerance.
ratios: setup
	$(BIN)/python -m tests.speed --check

# Compare the process model with published and measured numbers; then change one law at a time: which rows notice?
validate: setup
	$(BIN)/python -m grind_env.validation
	$(BIN)/python -m grind_env.validation --mutate

# Execute notebooks that are older than the package or than themselves, into build/notebooks.
notebooks: setup $(patsubst %,build/%,$(wildcard notebooks/*.ipynb))

# Compare their outputs with those in git; `docs/tools/shown.py keep` takes over the new outputs.
shown: notebooks
	$(BIN)/python docs/tools/shown.py compare

build/notebooks/%.ipynb: notebooks/%.ipynb $(STAMP) $(shell find grind_env -type f -not -name '*.pyc')
	$(BIN)/python -m jupyter nbconvert --to notebook --execute --ExecutePreprocessor.timeout=1800 --output-dir build/notebooks $<

# The site, in build/docs: warnings are errors, examples in docstrings run, links within the site are checked.
SPHINX := $(BIN)/python -m sphinx -q -W --keep-going -c docs -d build/doctrees

docs: setup
	rm -rf build/docs build/doctrees
	$(BIN)/python docs/tools/sources.py build/pages
	$(SPHINX) -b html build/pages build/docs
	$(SPHINX) -b doctest build/pages build/doctests
	$(BIN)/python docs/tools/links.py build/docs
	$(BIN)/python docs/tools/pictures.py build/docs

# The site without running its pages and examples.
pages: setup
	rm -rf build/docs build/doctrees
	$(BIN)/python docs/tools/sources.py build/pages
	$(SPHINX) -D nb_execution_mode=off -D suppress_warnings=myst-nb.lexer -b html build/pages build/docs

# A core install, without torch and Stable-Baselines3, imports, registers and steps every environment.
core:
	$(PYTHON) -m venv build/core
	build/core/bin/python -m pip install --quiet --disable-pip-version-check $(PINNED) .
	cd build && core/bin/python ../.ci/core_install.py

# The contract of the environments on the Gymnasium that RLlib pins, without torch and Stable-Baselines3.
contract:
	$(PYTHON) -m venv build/contract
	grep -v '^gymnasium==' constraints.txt > build/contract/constraints.txt
	build/contract/bin/python -m pip install --quiet --disable-pip-version-check $(if $(PINNED),-c build/contract/constraints.txt) \
		'.[render]' gymnasium==1.2.2 hypothesis pytest pytest-timeout pytest-xdist
	build/contract/bin/python -m pytest -n 2 tests/envs/test_env_contract.py tests/envs/test_vector_promises.py tests/envs/test_wrappers.py

# Run the code blocks of README and site with an installed wheel; `make blocks PAGES=docs/howto/shop.md`: of one page.
blocks:
	$(PYTHON) -m venv --clear build/blocks
	build/blocks/bin/python -m pip wheel --quiet --disable-pip-version-check --no-deps --wheel-dir build/wheel .
	build/blocks/bin/python -m pip install --quiet --disable-pip-version-check $(PINNED) \
		"grind_env[plot,render,sb3,shop] @ file://$(CURDIR)/$$(ls -t build/wheel/grind_env-*.whl | head -1)" \
		h5py minari tensorboard
	build/blocks/bin/python .ci/blocks.py build/blocks/bin $(PAGES)

# The video recorders of Gymnasium and Stable-Baselines3 use moviepy, which needs an older Pillow than our extras.
films:
	$(PYTHON) -m venv build/films
	grep -v '^pillow==' constraints.txt > build/films/constraints.txt
	build/films/bin/python -m pip install --quiet --disable-pip-version-check --constraint build/films/constraints.txt \
		'.[sb3]' hypothesis moviepy pytest pytest-timeout
	build/films/bin/python -m pytest tests/sb3/test_films.py

# Code blocks of the site whose library needs its own virtual environment.
libraries:
	$(PYTHON) -m venv --clear build/blocks
	build/blocks/bin/python -m pip install --quiet --disable-pip-version-check $(PINNED) markdown-it-py
	build/blocks/bin/python -m pip wheel --quiet --disable-pip-version-check --no-deps --wheel-dir build/wheel .
	build/blocks/bin/python .ci/libraries.py $$(ls -t build/wheel/grind_env-*.whl | head -1)

# Known vulnerabilities of the pinned versions.
audit: build/audit/bin/pip-audit
	build/audit/bin/python .ci/audit.py

build/audit/bin/pip-audit:
	$(PYTHON) -m venv build/audit
	build/audit/bin/python -m pip install --quiet --disable-pip-version-check pip-audit

# Wheel and sdist, in dist/.
package:
	$(PYTHON) -m venv build/package
	build/package/bin/python -m pip install --quiet --disable-pip-version-check $(PINNED) build check-wheel-contents twine
	rm -rf dist
	build/package/bin/python -m build --outdir dist .
	build/package/bin/python -m twine check --strict dist/*
	build/package/bin/check-wheel-contents dist/*.whl

clean:
	rm -rf $(VENV) build dist
