# make            builds the library and the program, Release: build/release/apps/holdfast
# make demo       installs what is missing, builds, tracks a hand-held box through a recorded video: out/demo
# make test       installs what is missing, then format check, build with warnings as errors, all tests
# make sanitize   the tests again with ASan and UBSan, threads with TSan; make fuzz: FUZZ_SECONDS (60) of made-up input for each reader
# make endurance  500 starts in a row in a large environment; 50,000 frames, over which memory must stay flat, and
#                 10,000 calls from Python
# make bench      installs what is missing, then measures: out/bench/report.txt, result.json and plots; compared with
#                 BASELINE where there is one (make bench-baseline saves the last result there, make bench-docs the
#                 tables and plots of docs/results/performance.md)
# make experiments  installs what is missing, then the paper's experiments again: docs/results/experiments.md and its
#                 pictures; SEEDS=1 for a quick pass, SEQUENCES=folder for recorded sequences too
# make robustness  installs what is missing, then what the tracker bears: wrong starts, other light, other objects,
#                 covariance: docs/results/robustness.md; each part switched off: docs/results/experiments.md;
#                 SEQUENCES=folder for recorded sequences too, PARTS=starts,small for some of it
# make results    the RBOT protocol on SEQUENCES=folder with and without texture: docs/results/rbot.md, README's table
# make modalities texture, contour and edges alone and together, and grey recordings: docs/results/modalities.md
# make devices    this machine's processor beside its graphics processor on SEQUENCES=folder: docs/results/devices.md
# make starts     starts without a first pose on SEQUENCES=folder: docs/results/starts.md; PARTS=starts,guided for some of it
# make recovery   installs what is missing, then 80 trials of objects that were covered or away, printed ones and shapes
#                 alone: docs/results/recovery.md
# make hazards    installs what is missing, then cases in which a tracker may hold a wrong pose: docs/results/hazards.md;
#                 CASES=a,b for some of them, printed only; SEEDS=3, JUMPS=20; SEQUENCES=folder: jumps within these too
# make docs       installs what is missing, then builds all documents with the C++ and Python interfaces as one site:
#                 out/docs/site; make options: docs/reference/options.md; make picture: the README's, of `make demo`
# make install    installs below PREFIX (/usr/local): make install PREFIX=DIR
# make wheel      installs what is missing, then builds the Python package as a wheel: out/wheel
# make deps       installs what is missing (cmake/packages.txt, cmake/python-packages.txt); make format, make clean
# make help       prints this
JOBS ?= $(shell nproc)
PREFIX ?= /usr/local
OUT ?= out/demo
BENCH ?= out/bench
BASELINE ?= $(BENCH)/baseline.json
BENCH_DOCS ?= docs/results/performance
venv := build/venv
CMAKE_FLAGS ?=
CTEST_FLAGS ?=
FUZZ_SECONDS ?= 60

release := build/release
tested := build/test

.PHONY: all deps demo experiments robustness recovery hazards results modalities devices starts test sanitize fuzz endurance bench bench-baseline bench-docs install format check-format clean help

all:
	cmake -S . -B $(release) -DCMAKE_BUILD_TYPE=Release -DHOLDFAST_BUILD_TESTS=OFF $(CMAKE_FLAGS)
	cmake --build $(release) --parallel $(JOBS)

deps:
	@sh cmake/install-deps.sh build test python
	@sh cmake/make-venv.sh $(venv) build test

demo:
	@sh cmake/install-deps.sh build
	@$(MAKE) --no-print-directory all
	@sh apps/demo/run_demo.sh $(release)/apps/holdfast $(OUT)

experiments:
	@sh cmake/install-deps.sh build experiments
	@$(MAKE) --no-print-directory all
	@python3 -B apps/experiments/run.py --program $(release)/apps/holdfast --work out/experiments \
	  --document docs/results/experiments.md --threads $(JOBS) $(if $(SEEDS),--seeds $(SEEDS)) \
	  $(if $(SEQUENCES),--sequences $(SEQUENCES))

results:
	@sh cmake/install-deps.sh build experiments
	@$(MAKE) --no-print-directory all
	@python3 -B apps/experiments/rbot.py --program $(release)/apps/holdfast --sequences $(SEQUENCES) \
	  --readme README.md

modalities: python
	@PYTHONPATH=build/python/python $(venv)/bin/python -B apps/experiments/modalities.py \
	  --program build/python/apps/holdfast --sequences $(SEQUENCES)

devices:
	@sh cmake/install-deps.sh build experiments
	@$(MAKE) --no-print-directory all
	@python3 -B apps/experiments/devices.py --program $(release)/apps/holdfast --sequences $(SEQUENCES)

starts:
	@sh cmake/install-deps.sh build experiments
	@$(MAKE) --no-print-directory all
	@python3 -B apps/experiments/starts.py --program $(release)/apps/holdfast --sequences $(SEQUENCES) $(if $(PARTS),--parts $(PARTS))

recovery: python
	@PYTHONPATH=build/python/python $(venv)/bin/python -B apps/experiments/recovery.py --document docs/results/recovery.md

hazards:
	@sh cmake/install-deps.sh build experiments
	@$(MAKE) --no-print-directory all
	@python3 -B apps/experiments/hazards.py --program $(release)/apps/holdfast --work out/hazards --threads $(JOBS) \
	  $(if $(CASES),--cases $(CASES),--document docs/results/hazards.md) $(if $(SEEDS),--seeds $(SEEDS)) \
	  $(if $(JUMPS),--jumps $(JUMPS)) $(if $(SEQUENCES),--sequences $(SEQUENCES))

robustness:
	@sh cmake/install-deps.sh build experiments
	@$(MAKE) --no-print-directory all
	@python3 -B apps/experiments/robustness/run.py --program $(release)/apps/holdfast --work out/robustness \
	  --document docs/results/robustness.md --ablation-document docs/results/experiments.md \
	  --threads $(JOBS) --demo $(OUT) $(if $(PARTS),--only $(PARTS)) \
	  $(if $(SEQUENCES),--sequences $(SEQUENCES))

# Compiled kernels go to the build folder: each run of a new build starts cold, and nothing is left in HOME.
test: export HOLDFAST_CACHE_DIR := $(CURDIR)/$(tested)/kernels
test: export POCL_CACHE_DIR := $(CURDIR)/$(tested)/pocl
test: deps
	sh cmake/check-format.sh
	cmake -S . -B $(tested) -DCMAKE_BUILD_TYPE=Release -DHOLDFAST_WARNINGS_AS_ERRORS=ON -DHOLDFAST_SECOND_OPENCL=ON \
	  -DHOLDFAST_BUILD_PYTHON=ON -DPython_EXECUTABLE=$(CURDIR)/$(venv)/bin/python $(CMAKE_FLAGS)
	cmake --build $(tested) --parallel $(JOBS)
	mkdir -p $(tested)/pocl
	$(tested)/apps/holdfast devices
	cd $(tested) && ctest --output-on-failure --no-tests=error --parallel $(JOBS) $(CTEST_FLAGS)
	@sh tests/count.sh $(tested)/Testing/Temporary/LastTest.log

# TSan over what runs in threads, ASan and UBSan over the suites; what others' libraries do is named in tests/sanitize/.
sanitize:
	@sh cmake/install-deps.sh build test
	@sh tests/sanitize/threads.sh build/sanitize-threads
	@sh tests/sanitize/run.sh build/sanitize $(CTEST_FLAGS)

fuzz:
	@sh cmake/install-deps.sh build fuzz
	@sh tests/fuzz/run.sh build/fuzz $(FUZZ_SECONDS)

endurance:
	@sh cmake/install-deps.sh build test
	@$(MAKE) --no-print-directory all python
	@python3 -B tests/endurance/run.py $(release)/apps/holdfast out/endurance
	@HOLDFAST_CALLS=10000 PYTHONPATH=build/python/python $(venv)/bin/python -B -m pytest -q -s -p no:cacheprovider \
	  tests/python/test_tracker.py -k memory_stays

bench:
	@sh cmake/install-deps.sh build bench
	cmake -S . -B $(release) -DCMAKE_BUILD_TYPE=Release -DHOLDFAST_BUILD_TESTS=OFF -DHOLDFAST_BUILD_BENCHMARKS=ON $(CMAKE_FLAGS)
	cmake --build $(release) --parallel $(JOBS)
	python3 tests/benchmarks/run.py $(release) $(BENCH)
	python3 tests/benchmarks/report.py $(BENCH)/result.json $(BASELINE) | tee $(BENCH)/report.txt
	python3 tests/benchmarks/plots.py $(BENCH)/result.json $(BENCH)

bench-baseline:
	cp $(BENCH)/result.json $(BASELINE)

bench-docs:
	mkdir -p $(BENCH_DOCS)
	cp $(BENCH)/report.txt $(BENCH)/stages.svg $(BENCH)/sweeps.svg $(BENCH_DOCS)

# Builds only where nothing is built yet, so that `sudo make install` leaves no files of root in the build folder.
install:
	@test -x $(release)/apps/holdfast || $(MAKE) --no-print-directory all
	cmake --install $(release) --prefix $(PREFIX)

.PHONY: options python docs picture wheel
options: all
	python3 -B apps/docs/options.py $(release)/apps/holdfast

# The program and the Python package, in a folder of their own.
python:
	@sh cmake/install-deps.sh build python docs
	@sh cmake/make-venv.sh $(venv) build test docs
	cmake -S . -B build/python -DCMAKE_BUILD_TYPE=Release -DHOLDFAST_BUILD_TESTS=OFF -DHOLDFAST_BUILD_PYTHON=ON \
	  -DPython_EXECUTABLE=$(CURDIR)/$(venv)/bin/python $(CMAKE_FLAGS)
	cmake --build build/python --parallel $(JOBS)

docs: python
	@sh apps/docs/build.sh $(venv)/bin/python build/python/python out/docs

picture: python
	PYTHONPATH=build/python/python $(venv)/bin/python -B apps/demo/moving_picture.py $(OUT)/overlay.mp4 docs/images/demo.webp

wheel:
	@sh cmake/install-deps.sh build python
	@sh cmake/make-venv.sh $(venv) build
	$(venv)/bin/python -m pip wheel . --no-deps --no-build-isolation --wheel-dir out/wheel

format:
	sh cmake/check-format.sh --fix

check-format:
	sh cmake/check-format.sh

help:
	@sed -n '/^#/!q; s/^# //p' Makefile

clean:
	rm -rf $(release) $(tested) $(venv) build/python build/wheel
