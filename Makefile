# fpnav: make help
PYTHON ?= python3
VENV ?= .venv
BUILD ?= build
FPNAV_DATA ?= ../shared/data
export FPNAV_DATA
BIN := $(VENV)/bin
READY := $(VENV)/.fpnav-ready
DEMO := $(BUILD)/demo
.DEFAULT_GOAL := help
.DELETE_ON_ERROR:

##@ First steps
.PHONY: help
help: ## Show this list
	@awk 'BEGIN {FS = ":.*## "} /^##@/ {printf "\n%s\n", substr($$0, 5)} \
		/^[a-z-]+:.*## / {printf "  %-16s %s\n", $$1, $$2}' $(MAKEFILE_LIST)

.PHONY: demo
demo: $(READY) ## Walk a sample log through every stage; ends with the path of the page
	@mkdir -p $(DEMO)
	$(BIN)/fpnav ingest sample_logs/office_map.mcap -o $(DEMO)/map_run.mcap
	$(BIN)/fpnav ingest sample_logs/office_test.mcap -o $(DEMO)/test_run.mcap
	$(BIN)/fpnav extract $(DEMO)/map_run.mcap -s fingerprint -o $(DEMO)/map_run.h5
	$(BIN)/fpnav build-map $(DEMO)/map_run.h5 -o $(DEMO)/map.h5
	$(BIN)/fpnav localize $(DEMO)/map.h5 $(DEMO)/test_run.mcap --method match -o $(DEMO)/match.h5
	$(BIN)/fpnav localize $(DEMO)/map.h5 $(DEMO)/test_run.mcap --method filter -o $(DEMO)/filter.h5
	$(BIN)/fpnav report $(DEMO)/match.h5 $(DEMO)/filter.h5 -o $(DEMO)/report \
		--log $(DEMO)/map_run.mcap --log $(DEMO)/test_run.mcap

.PHONY: test
test: $(READY) ## Run the tests (under 5 minutes)
	$(BIN)/python -m pytest -m "not slow" -n 2

##@ Development
.PHONY: test-slow
test-slow: $(READY) ## Run the long tests: sweeps over every byte, kill and disk-full sweeps
	$(BIN)/python -m pytest -m slow -n 2 --dist worksteal --timeout 600

.PHONY: check
check: lint test docs ## Format, lint, types, tests, docs

.PHONY: lint
lint: $(READY) ## Format check, ruff, mypy --strict
	$(BIN)/ruff format --check fpnav tests benchmarks docs
	$(BIN)/ruff check fpnav tests benchmarks docs
	$(BIN)/mypy

.PHONY: docs
docs: $(READY) ## Build the documentation into build/docs
	$(BIN)/sphinx-build -W -q -b html docs $(BUILD)/docs

.PHONY: bench
bench: $(READY) ## Print the figures of README's speed table
	$(BIN)/python -m benchmarks

.PHONY: real
real: $(READY) ## Run every system on the recordings of FPNAV_DATA and rewrite README's table
	$(BIN)/python -m benchmarks.real

.PHONY: sample-logs
sample-logs: $(READY) ## Make sample_logs/ anew, byte for byte
	$(BIN)/python sample_logs/make.py

SMALL := $(addprefix reproduce-small-,tapus kortenkamp giovannangeli)
.PHONY: reproduce-small $(SMALL)
reproduce-small: $(SMALL) ## Every paper's experiments in one world, shortened, to see that they run

$(SMALL): reproduce-small-%: $(READY)
	$(BIN)/fpnav reproduce $* --small --seeds 1 -o $(BUILD)/reproduce-small/$*

.PHONY: reproduce-kortenkamp
reproduce-kortenkamp: $(READY) ## Kortenkamp and Weymouth in twenty simulated buildings
	$(BIN)/fpnav reproduce kortenkamp --jobs 2 \
		--seeds 1,2,3,4,5,6,7,8,9,10,11,12,13,14,15,16,17,18,19,20 \
		-o $(BUILD)/reproduce/kortenkamp

.PHONY: reproduce-giovannangeli
reproduce-giovannangeli: $(READY) ## Giovannangeli et al. in five simulated worlds
	$(BIN)/fpnav reproduce giovannangeli --jobs 2 -o $(BUILD)/reproduce/giovannangeli

.PHONY: reproduce-tapus
reproduce-tapus: $(READY) ## Tapus et al. in five simulated offices
	$(BIN)/fpnav reproduce tapus --jobs 2 -o $(BUILD)/reproduce/tapus

.PHONY: clean
clean: ## Remove what was built, not the environment
	rm -rf $(BUILD) .pytest_cache .mypy_cache .ruff_cache

# The environment is made once and again whenever pyproject.toml changes.
$(READY): pyproject.toml
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[dev]'
	@touch $@
