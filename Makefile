# Every habit is one target; `make help` lists them. On a fresh machine with a Rust toolchain, a C and C++ compiler, make and
# Python 3.10 or newer, `make run` and `make test` set up everything they need.

SHELL  := /bin/sh
PYTHON ?= python3
VENV   := .venv
# Looked for outside the environment: it cannot be made anew with its own interpreter.
FOUND  := $(shell PATH="$$(printf %s "$$PATH" | sed 's|$(CURDIR)/$(VENV)/bin:||g')" command -v $(PYTHON))
PIP    := $(VENV)/bin/python -m pip --disable-pip-version-check
PYTEST := $(VENV)/bin/python -m pytest
TARGET := $(or $(CARGO_TARGET_DIR),target)

# CMake 3 for the C++ library of chemfiles comes from the virtual environment; a newer one on the machine must not be found first.
export PATH := $(CURDIR)/$(VENV)/bin:$(PATH)

# One profile with chemfiles for everything: its C++ library, by far the longest part of a first build, is compiled once per
# profile, so `run`, `test`, `lint` and `bench` all use the release profile and share it. The checks of a debug build (integer
# overflow, debug assertions) are had from the same tests built without chemfiles, which needs no C++.
FLAGS := --release

.DEFAULT_GOAL := help
.PHONY: help run build test test-rust test-minimal test-python lint validate bench bench-quick bench-gpu paper stability gpu-bundle gpu-peers fuzz clean check-tools

help: ## list the targets
	@grep -hE '^[a-z-]+:.*## ' $(MAKEFILE_LIST) | sed -E 's/^([a-z-]+):.*## (.*)/  make \1|\2/' | column -t -s '|' 2>/dev/null \
	  || grep -hE '^[a-z-]+:.*## ' $(MAKEFILE_LIST)

run: build ## build, then run the main scene, inputs/melt.in (its files go to output/)
	@mkdir -p output
	$(TARGET)/release/octant run inputs/melt.in -v out=output --log output/log.octant

build: $(VENV)/.ready ## build the release binary
	cargo build $(FLAGS)

test: lint test-rust test-minimal test-python ## every test: Rust, the build without chemfiles, Python with LAMMPS

test-rust: $(VENV)/.ready ## Rust tests, with chemfiles
	cargo test $(FLAGS)

# A target folder of its own, so that neither build throws the other's binary away.
test-minimal: check-tools ## Rust tests without chemfiles and CMake, with overflow checks and debug assertions
	cargo test --no-default-features --target-dir $(TARGET)/minimal

test-python: build ## Python tests: comparison with LAMMPS, logs and trajectories as other tools read them, the README
	$(PYTEST) validation

lint: $(VENV)/.ready ## formatting and lints
	cargo fmt --check
	cargo clippy $(FLAGS) --all-targets -- -D warnings

validate: build ## every scene through LAMMPS and octant; table, JSON and plot in validation/results/
	$(VENV)/bin/python -m validation

bench: build $(VENV)/.bench ## benchmarks: parts, then whole runs beside LAMMPS and OpenMM; results in validation/results/bench/
	cargo bench
	$(VENV)/bin/python -m validation.bench

bench-quick: build $(VENV)/.bench ## a minute of whole runs, results in output/bench/; shows that the benchmark works
	$(VENV)/bin/python -m validation.bench --quick --output output/bench

bench-gpu: build $(VENV)/.bench-gpu ## octant bench of every size beside OpenMM on this machine's GPU; results in output/bench-gpu/
	$(VENV)/bin/python -m validation.bench.gpu

paper: build ## experiments of the paper behind the octant search, on the CPU and, where there is one, on the GPU; output/paper/paper.md (PAPER_FLAGS=--quick)
	$(TARGET)/release/octant paper --backend cpu $(PAPER_FLAGS) --out output/paper/cpu
	@set -e; folders=output/paper/cpu; \
	if $(TARGET)/release/octant info | grep '^ *cuda device' >/dev/null; then \
	  folders="$$folders output/paper/cuda"; \
	  $(TARGET)/release/octant paper --backend cuda $(PAPER_FLAGS) --out output/paper/cuda; \
	fi; \
	$(VENV)/bin/python -m validation.paper $$folders --page output/paper/paper.md

stability: build ## stiff, extreme, overflowing and long scenes (1e6 steps) on every backend and precision; validation/stability.md
	$(VENV)/bin/python -m validation.stability

gpu-peers: $(VENV)/.ready ## OpenMM's wheels for a GPU machine without network (Python 3.12): bundle/gpu-peers/, to lie beside the bundle
	$(PIP) download --quiet --no-deps --only-binary=:all: --python-version 3.12 --implementation cp \
	  --platform manylinux_2_34_x86_64 --requirement validation/bench/gpu/requirements.txt --dest bundle/gpu-peers

gpu-bundle: $(VENV)/.ready ## tests and comparison for a machine with a GPU but no toolchain: bundle/octant-gpu.tar.xz, run.sh in it
	@command -v strip >/dev/null || { echo "make gpu-bundle needs strip (binutils)" >&2; exit 1; }
	$(VENV)/bin/python -m validation.bundle.make $(FLAGS)

fuzz: check-tools ## throw random bytes at the script reader for a minute (FUZZ_SECONDS=60)
	@command -v cargo-fuzz >/dev/null || { \
	  echo "make fuzz needs cargo-fuzz and a nightly toolchain: cargo install cargo-fuzz && rustup toolchain install nightly" >&2; exit 1; }
	for target in $$(cargo +nightly fuzz list --fuzz-dir tests/fuzz); do \
	  cargo +nightly fuzz run --fuzz-dir tests/fuzz $$target -- -max_total_time=$(or $(FUZZ_SECONDS),60) || exit 1; \
	done

clean: ## remove everything that was built, installed or written
	rm -rf $(TARGET) $(VENV) output bundle log.octant

check-tools:
	@command -v cargo >/dev/null || { \
	  echo "octant needs a Rust toolchain, and there is no cargo: install it from https://rustup.rs" >&2; exit 1; }

# The stamp is written last: an installation that was interrupted, or was made for other requirements, starts again from an empty folder.
$(VENV)/.ready: validation/requirements.txt | check-tools
	@command -v c++ >/dev/null && command -v cc >/dev/null || { \
	  echo "chemfiles needs a C and a C++ compiler (cc, c++). Debian, Ubuntu: sudo apt install build-essential; Fedora: sudo dnf install gcc-c++" >&2; exit 1; }
	@test -n "$(FOUND)" || { \
	  echo "octant's tools need Python 3.10 or newer, and there is no $(PYTHON). Debian, Ubuntu: sudo apt install python3 python3-venv" >&2; exit 1; }
	@"$(FOUND)" -c 'import sys; sys.exit(sys.version_info < (3, 10))' || { \
	  echo "octant's tools need Python 3.10 or newer; $(FOUND) is $$("$(FOUND)" -V 2>&1). Name a newer one: make PYTHON=/path/to/python3.12 ..." >&2; exit 1; }
	@"$(FOUND)" -c 'import ensurepip, venv' 2>/dev/null || { \
	  echo "$(FOUND) cannot make virtual environments, its venv module is incomplete. Debian, Ubuntu: sudo apt install python3-venv" >&2; exit 1; }
	"$(FOUND)" -m venv --clear $(VENV)
	$(PIP) install --quiet --requirement validation/requirements.txt
	@touch $@

# Apart from the other tools: no test needs it. The environment is cleared when it is made anew, and this stamp with it.
$(VENV)/.bench: validation/bench/requirements.txt $(VENV)/.ready
	$(PIP) install --quiet --requirement $<
	@touch $@

$(VENV)/.bench-gpu: validation/bench/gpu/requirements.txt $(VENV)/.ready
	$(PIP) install --quiet --requirement $<
	@touch $@
