# Needs Python 3.11 or newer, make and a network; everything else goes into .venv.
.DEFAULT_GOAL := help
.PHONY: help bench test slow docs site lint format lock clean

# Tried by running them: a version manager's stub can be on the PATH and still not start.
PYTHON ?= $(shell for p in python3.11 python3; do \
  $$p -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null && echo $$p && break; done)
VENV := .venv
BIN := $(VENV)/bin
READY := $(VENV)/.ready
OUT := out

help:
	@echo "make bench    set up, render a picture and a sequence, measure how it scales, write the report"
	@echo "make test     set up, run the tests"
	@echo "make slow     the tests that take minutes"
	@echo "make docs     the manual, as pages in $(OUT)/docs"
	@echo "make site     results/submissions as a page that sorts, and a CSV"
	@echo "make lint     ruff, mypy and the list of words;  make format  puts the style right"
	@echo "make lock     write requirements.lock anew (LOCK_ARGS=--upgrade for newer versions)"
	@echo "make clean    remove .venv, $(OUT) and caches"

bench: $(READY)
	@echo "about three minutes on two cores: a picture of the default preset, six frames of a crowd in haze,"
	@echo "the law held against counts of a field, and the report; everything comes into $(OUT)"
	$(BIN)/lodbench render meadow -o '$(OUT)/meadow.####.exr' \
	  --size 960x540 --spp 16 --preview --overwrite
	$(BIN)/lodbench render crowd -o '$(OUT)/crowd/crowd.####.exr' \
	  --frames 1-6 --size 320x180 --spp 16 --preview --overwrite
	$(BIN)/lodbench run scaling --quick -o $(OUT)/records
	$(BIN)/lodbench report $(OUT)/records
	@echo
	@echo "open  $(OUT)/meadow.png            the first frame; its layers are in $(OUT)/meadow.0001.exr"
	@echo "      $(OUT)/crowd/crowd.png       the sequence as a contact sheet, crowd.mp4 as a film"
	@echo "      $(OUT)/records/report.html   the law as a plot, and what was judged"

# Each process has half of the tests, file by file, as what a file's tests share is made once; who
# is done first takes of the other's.
test: $(READY)
	@echo "about eight minutes on two idle cores"
	$(BIN)/python -m pytest -n 2 --dist worksteal

slow: $(READY)
	$(BIN)/python -m pytest -n 2 --dist worksteal -m slow

docs: $(READY)
	$(BIN)/python docs/write_keys.py
	$(BIN)/python docs/write_figures.py
	$(BIN)/python docs/write_notebook.py
	$(BIN)/sphinx-build --quiet --nitpicky --fail-on-warning --keep-going -c docs . $(OUT)/docs
	@echo "manual  $(OUT)/docs/docs/index.html"

site: $(READY)
	$(BIN)/python -m bench.submissions.site results/submissions '$(OUT)/site'

lint: $(READY)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy lod scenes bench lodbench.py
	$(BIN)/python tests/tools/words.py

format: $(READY)
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

# Every package comes from the lock, the build backend included: hence no build isolation.
$(READY): requirements.lock pyproject.toml
	@test -n "$(PYTHON)" || { echo "lodbench needs Python 3.11 or newer, and neither python3.11" \
	  "nor python3 is one. Install it, or name it: make PYTHON=/path/to/python3" >&2; exit 2; }
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { echo "lodbench needs" \
	  "Python 3.11 or newer, and PYTHON=$(PYTHON) is not one. Name another." >&2; exit 2; }
	@$(PYTHON) -c 'import ensurepip, venv' 2>/dev/null || { echo "$(PYTHON) cannot make a virtual" \
	  "environment. On Debian or Ubuntu: apt-get install python3-venv" >&2; exit 2; }
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --require-hashes -r requirements.lock
	$(BIN)/python -m pip install --quiet --no-deps --no-build-isolation -e .
	@touch $@

# No registry and no path of this machine may reach the lock.
LOCK_VENV := .venv-lock
lock:
	$(PYTHON) -m venv $(LOCK_VENV)
	$(LOCK_VENV)/bin/python -m pip install --quiet 'pip-tools==7.6.2'
	env -u PIP_FIND_LINKS -u PIP_EXTRA_INDEX_URL CUSTOM_COMPILE_COMMAND='make lock' \
	  $(LOCK_VENV)/bin/pip-compile --quiet --all-extras --all-build-deps --allow-unsafe \
	  --strip-extras --generate-hashes --no-emit-index-url --no-emit-find-links \
	  --no-emit-trusted-host $(LOCK_ARGS) -o requirements.lock pyproject.toml
	@! grep -nE '://|(^| )/' requirements.lock

clean:
	rm -rf $(VENV) $(LOCK_VENV) $(OUT) .hypothesis .mypy_cache .pytest_cache .ruff_cache
	find lod scenes bench tests -name __pycache__ -type d -prune -exec rm -rf {} +
