# make demo   the main job on a fresh clone: makes the environment, speaks a sentence, shows where the results lie
# make test   all tests (sets up what they need); make test-quick: those that are fast, in under a minute
# make check  format, lint, types, import contract
# make sheets the pictures in docs/
# make mutants  a sample of changed lines: does a test notice?
# make fuzz   damaged files for every reader, MINUTES=60; what breaks is kept in fuzz-faults/
# make soak   ordinary and hostile clients at the studio and the live stream, SOAK_MINUTES=20; memory is printed
# make kills  long commands killed at random moments go on to the same bits, ROUNDS=10
# make lock   requirements/ made again, after a change of pyproject.toml or constraints.txt
# make site   the documentation as a site, in site/
# make page   the studio's page, built from studio/ and viewer/ into src/mien/assets/studio (wants Node)
# make blender            the Blender extension, dist/mien_blender-*.zip (docs/blender.md)
# make setup-blender      Blender as a Python module (350 MB, GPL, a program apart) for the tests of the extension and FBX
# make setup-festival   Festival with its English and Finnish voices, a separate program (Debian, Ubuntu; needs root)

PYTHON ?= python3
VENV ?= .venv
BIN := $(VENV)/bin
PIP := $(BIN)/python -m pip --disable-pip-version-check
DEMO ?= demo
MUTANTS ?= 200
# One process more than cores, as some tests wait for browsers, sockets and other processes; the longest files first.
PROCESSES ?= $(shell expr $$(nproc 2>/dev/null || echo 2) + 1)
IN_PARALLEL := --numprocesses $(PROCESSES) --dist loadfile --no-loadscope-reorder
SEED ?= 1
UV := 0.13.9
SENTENCE ?= I never said that. Maybe five people heard my voice!

# Where this is set, each of the hundreds of processes that tests start would compile all modules again.
unexport PYTHONDONTWRITEBYTECODE

# Node's packages as pinned, installed once for each change of the lock file.
studio/node_modules/.mien-lock: studio/package-lock.json
	cd studio && npm ci
	cp $< $@

.PHONY: site setup-festival setup-blender blender demo test test-quick slow-tests mutants check format wheel sheets page fuzz soak kills lock clean

$(BIN)/python:
	$(PYTHON) -m venv $(VENV)

# Packages are pinned with the hashes of their files (requirements/, by 'make lock'); mien itself is built with what is there.
$(VENV)/.core: pyproject.toml requirements/core.txt | $(BIN)/python
	@echo "installing pinned packages (about 300 MB to fetch, once)"
	$(PIP) install --quiet --require-hashes --requirement requirements/core.txt
	$(PIP) install --quiet --no-deps --no-build-isolation --editable .
	@touch $@

$(VENV)/.dev: $(VENV)/.core requirements/dev.txt
	$(PIP) install --quiet --require-hashes --requirement requirements/core.txt --requirement requirements/dev.txt
	@touch $@

lock: $(VENV)/.dev
	$(PIP) install --quiet uv==$(UV)
	$(BIN)/python tools/lock.py

demo: $(VENV)/.core
	@mkdir -p $(DEMO)
	$(BIN)/mien warm-up
	@echo "1. a sentence"
	$(BIN)/mien say "$(SENTENCE)" --emotion happy:0.5 -o $(DEMO)/sentence.mp4 --also $(DEMO)/sentence.glb --also $(DEMO)/sentence.wav
	@echo "2. a recording with its text (the sound of the first step)"
	$(BIN)/mien animate $(DEMO)/sentence.wav --text "$(SENTENCE)" -o $(DEMO)/recording.mp4 --also $(DEMO)/recording.glb
	@echo
	@echo "Watch:   $(abspath $(DEMO))/sentence.mp4"
	@echo "         $(abspath $(DEMO))/recording.mp4"
	@echo "Open:    $(abspath $(DEMO))/sentence.glb (any 3D program)"
	@echo "         $(abspath $(DEMO))/recording.glb"

test: $(VENV)/.dev
	$(BIN)/python -m pytest $(IN_PARALLEL)

# What is fast enough to run at every save; tests/slow_tests.txt is written from the times of a whole run.
test-quick: $(VENV)/.dev
	$(BIN)/python -m pytest $(IN_PARALLEL) -m "not slow" -q

slow-tests: $(VENV)/.dev
	$(BIN)/python -m pytest $(IN_PARALLEL) -q --junitxml=test-times.xml || true
	$(BIN)/python tools/slow_tests.py test-times.xml

# Does a test notice a changed line? MUTANTS=200 in the core rooms, drawn with SEED=1; one at a time on each core, about an hour on two.
mutants: $(VENV)/.dev
	$(BIN)/python tools/mutants.py --number $(MUTANTS) --seed $(SEED)

check: $(VENV)/.dev
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy
	$(BIN)/lint-imports --no-cache

format: $(VENV)/.dev
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .

wheel: $(VENV)/.dev
	$(PIP) wheel --quiet --no-deps --no-build-isolation --wheel-dir dist .
	@ls -l dist

FESTIVAL := festival festvox-suopuhe-lj festvox-suopuhe-mv festvox-us-slt-hts festvox-kallpc16k

setup-festival:
	apt-get update -qq
	DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends $(FESTIVAL)

BPY ?= 4.5.15
setup-blender: .venv-blender/.bpy-$(BPY)
.venv-blender/.bpy-$(BPY):
	$(PYTHON) -m venv .venv-blender
	.venv-blender/bin/python -m pip --disable-pip-version-check install --quiet bpy==$(BPY)
	@touch $@

blender: $(VENV)/.core
	@$(BIN)/python blender/build.py

sheets: $(VENV)/.dev
	$(BIN)/python tools/render_sheets.py --out docs/pictures
	$(BIN)/mien inspect default -o docs/pictures/performer
	$(BIN)/mien say "I never said that." --emotion angry --face vera -o docs/pictures/line.gif --size 360x360 --fps 15
	rm -f docs/pictures/performer/key-shapes-*.png

page: studio/node_modules/.mien-lock
	cd studio && npm run types && npm run build

clean:
	rm -rf $(VENV) .venv-blender $(DEMO) build dist

MINUTES ?= 60
SOAK_MINUTES ?= 20
ROUNDS ?= 10
soak: $(VENV)/.dev
	$(BIN)/python -m tools.soak --minutes $(SOAK_MINUTES)

kills: $(VENV)/.dev
	$(BIN)/python -m tools.kills --rounds $(ROUNDS)

fuzz: $(VENV)/.dev
	$(BIN)/python -m tools.fuzz --minutes $(MINUTES)

# The documentation as a site in site/, with search that works offline; in an environment of its own.
site: $(VENV)/.core
	$(PYTHON) -m venv .venv-site
	.venv-site/bin/python -m pip install --quiet --disable-pip-version-check mkdocs-material==9.8.2 'mkdocstrings[python]==1.0.8'
	.venv-site/bin/mkdocs build --strict --quiet
	@echo "Open: $(abspath site)/index.html"
