# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
#
# One target a line. What is missing is set up and built first. ARGS= is passed on.
#
#   make                 build everything; the first time also set up ROS in .venv
#   make run             a simulated robot, its driver and web page; PORT=/dev/ttyUSB0: a real robot;
#   make run             with ARGS='--ros-args -p NAME:=VALUE'; ARGS='--host 0.0.0.0': for phones
#   make demo            a tour of a simulated robot, recorded and reported on: three minutes
#   make test            build, lint and test, about four minutes; ARGS='FILE -k NAME' runs some tests
#   make build           the same as make
#   make nightly         all that takes long: hours; SHARE=0.1: a tenth of it; ARGS as above
#   make lint            ruff and mypy
#   make docs            write the generated tables and figures into the documents
#   make pictures        draw the pictures of the documents again: a minute
#   make bench           measure latency and cost: ten minutes; ARGS="--beside 'COMMAND'"
#   make bench-odometry  measure the odometry
#   make bench-goals     measure how exact goals are
#   make size            count lines, files and words, beside what they should be at most
#   make clean           remove all that was installed, built and measured
#   make help            print this
SHELL := bash
.DEFAULT_GOAL := build
.PHONY: help run demo test nightly build bench bench-odometry bench-goals docs pictures lint size clean

# A misspelt variable must not start something else.
KNOWN := PORT ARGS SHARE PYTHON CC CXX
UNKNOWN := $(filter-out $(KNOWN) -%,$(foreach each,$(.VARIABLES),$(if $(filter command,$(origin $(each))),$(each))))
$(if $(UNKNOWN),$(error no variable is called $(UNKNOWN): allowed are $(KNOWN)))

# Use an installed ROS if it is sourced, else ROS from wheels in .venv.
KIND := $(if $(and $(filter jazzy,$(ROS_DISTRO)),$(AMENT_PREFIX_PATH)),jazzy,wheels)
READY := .venv/ready
TESTS := .venv/ready_for_tests
BUILT := install/built
MUTANTS := build/mutants/ready
PYTEST := python -m pytest -n 4 --dist loadfile --no-loadscope-reorder --max-worker-restart 0
ENTER := source ./env.sh &&

help: ; @sed -n 's/^#   make/make/p' Makefile
run: build ; @$(ENTER) exec create_run $(if $(PORT),--port $(PORT)) $(ARGS)
demo: build ; @$(ENTER) exec tools/demo.sh
test: build lint ; @$(ENTER) $(if $(ARGS),python -m pytest $(ARGS),$(PYTEST))
nightly: build $(TESTS) $(MUTANTS) ; @$(ENTER) $(if $(ARGS),,$(PYTEST) --cov --cov-report= && python tools/coverage_floors.py &&) python -m pytest -m nightly -rP $(ARGS)
build: $(BUILT)
bench: build $(TESTS) ; @$(ENTER) python bench/bench_latency.py && python bench/bench_web.py && python bench/bench_cost.py $(ARGS)
bench-odometry: build $(TESTS) ; @$(ENTER) python bench/bench_odometry.py $(ARGS)
bench-goals: build $(TESTS) ; @$(ENTER) python bench/bench_goals.py $(ARGS)
docs: build $(TESTS) ; @$(ENTER) PYTHONPATH=bench:$$PYTHONPATH python tools/document.py config/create.yaml config/sros2_policy.xml docs/*.md bench/RESULTS.md && xacro urdf/create.urdf.xacro -o urdf/create.urdf
pictures: build $(TESTS) ; @$(ENTER) python bench/draw_odometry.py && python bench/draw_lidar.py
lint: $(TESTS) ; @.venv/bin/ruff check --quiet $$(git ls-files '*.py') && .venv/bin/mypy --no-error-summary
size: ; @python3 tools/size.py
clean: ; @for each in .venv build install; do case "$$(readlink $$each)" in */create_oi_ros-*) rm -rf "$$(dirname "$$(readlink $$each)")" ;; esac; done; rm -rf .venv build install log *.egg-info .coverage* .mypy_cache .ruff_cache .pytest_cache .hypothesis

# Variables of another ROS, or of env.sh, must not reach the wheels.
ifeq ($(KIND),wheels)
unexport PYTHONPATH PYTHONHOME LD_LIBRARY_PATH COLCON_PREFIX_PATH _ROS_WHEELS_BOOTSTRAP_COMPLETE
endif

# Python keeps what it compiles, even where it was told not to: programs start twice as fast.
unexport PYTHONDONTWRITEBYTECODE

# If .venv is for the other kind of ROS, or the folder has moved, make it again.
ifneq ($(file <$(READY)),$(KIND) $(CURDIR))
.PHONY: $(READY)
endif

$(READY): tools/pins.txt tools/make_venv.py tools/folders.py tools/patch_cmake.py
	@rm -f $@ && python=$$(tools/find_python.sh $(KIND)) && $$python tools/make_venv.py $(KIND)
	@echo '$(KIND) $(CURDIR)' > $@

$(TESTS): tools/test_pins.txt $(READY)
	@.venv/bin/python tools/make_venv.py $(KIND) test && touch $@

# cosmic-ray is beside .venv, since only mutants need it.
$(MUTANTS): tools/mutants.txt $(READY)
	@rm -rf $(@D) && .venv/bin/python -m venv $(@D) && $(@D)/bin/pip install -q --no-deps -r $<
	@touch $@

# Folders are inputs, too: their time changes when a file is added or removed.
INPUTS := $(shell find msg_defs tools/tf2_msgs resource launch config urdf rviz 2>/dev/null)
$(BUILT): $(READY) $(INPUTS) package.xml setup.py setup.cfg tools/build.py
	@.venv/bin/python tools/build.py $(KIND)
	@echo '$(CURDIR)' > $@
