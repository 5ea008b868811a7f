# make run, make test, make lint: each sets up .venv first where that is not done yet.

WHY := hopslam needs CPython 3.11, 3.12 or 3.13 with venv (3.11 is best: PyBullet has wheels for no newer one), or uv
# Python compiles to bytecode what it imports, and keeps it; pip would compile every file of every package.
unexport PYTHONDONTWRITEBYTECODE
PIP := pip install --quiet --no-compile
INSTALL := .venv/bin/$(PIP)

.PHONY: run test test-all test-ros bench-ros coverage smoke lint format schema docs pictures pins licences release clean

run: .venv/.run
	.venv/bin/hopslam run corridor

# Two workers more than cores, for some tests wait for emulated devices.
test: .venv/.dev
	PYTEST_XDIST_AUTO_NUM_WORKERS=$$(($$(getconf _NPROCESSORS_ONLN) + 2)) \
	    .venv/bin/python -m pytest -q -n auto --dist loadfile

# With what takes hours too: every point at which a write can fail, commands killed at random moments, long runs.
test-all: .venv/.dev
	.venv/bin/python -m pytest -q -n auto --dist loadfile --all-faults

# Lines and branches that tests run, by package, and those of the core that none runs. Coverage cannot look into compiled
# code, so tests of the core that are quick enough run uncompiled too: some minutes. Each package of the core must have
# 95 %. `make coverage TESTS="tests/test_arcos.py ..."` takes less, and says what these tests run.
TESTS := tests
UNCOMPILED := $(patsubst %,tests/test_%.py,main_edges marginals place_search pose_graph rare_cases small_fans)
CORE := slam/lines slam/mapping slam/matching slam/graph hardware/arcos hardware/scip
COVERAGE := .venv/bin/coverage

coverage: .venv/.dev
	$(INSTALL) --group coverage
	$(COVERAGE) erase
	$(COVERAGE) run -m pytest -q -n auto --dist loadfile $(TESTS)
	NUMBA_DISABLE_JIT=1 $(COVERAGE) run -m pytest -q $(UNCOMPILED)
	$(COVERAGE) combine --quiet
	$(COVERAGE) json --quiet -o .coverage.json
	@$(COVERAGE) report --skip-covered --show-missing --include="$$(printf '%s/*,' $(CORE))"
	@.venv/bin/python tests/coverage_by_package.py .coverage.json $(CORE)

# Runs on topics of ROS 2, with the rclpy of two distributions as the other end; 600 MB of wheels, and ten minutes.
ROS_PYTHONS := $(CURDIR)/.venv-ros/jazzy/bin/python:$(CURDIR)/.venv-ros/kilted/bin/python

test-ros: .venv/.ros .venv-ros/jazzy/.done .venv-ros/kilted/.done
	ROS_PYTHONS=$(ROS_PYTHONS) .venv/bin/python -m pytest -q tests/ros/check_ros.py

bench-ros: .venv/.ros .venv-ros/jazzy/.done .venv-ros/kilted/.done
	.venv/bin/hopslam bench ros $(subst :, ,$(ROS_PYTHONS))

# That hopslam installs and runs on a newer Python, too, where PyBullet has no wheel: the wheel, away from the checkout.
NEWER := $(shell for python in python3.13 python3.12 $(HOME)/.pyenv/versions/3.1[23].*/bin/python; do \
    $$python -c '' 2>/dev/null && echo $$python && break; done)

smoke:
ifeq ($(NEWER),)
	@echo 'smoke: SKIPPED, neither python3.13 nor python3.12 is here'
else
	$(NEWER) -m venv .venv-newer
	.venv-newer/bin/$(PIP) --require-hashes --requirement pins/run.txt
	.venv-newer/bin/$(PIP) --no-deps --no-build-isolation --force-reinstall .
	cd .venv-newer && bin/hopslam run corridor --set slam.mode=dead_reckoning --set duration=5
endif

# Types of all files on Linux, and of the packages on the other systems.
PACKAGES := hopslam sim slam hardware

lint: .venv/.dev
	.venv/bin/ruff check .
	.venv/bin/ruff format --check .
	printf '%s\n' linux 'win32 $(PACKAGES)' 'darwin $(PACKAGES)' | \
	    xargs -P 3 -L 1 sh -c '.venv/bin/mypy --platform $$0 --cache-dir .mypy_cache/$$0 "$$@"'
	.venv/bin/lint-imports --no-cache

format: .venv/.dev
	.venv/bin/ruff check --fix .
	.venv/bin/ruff format .

# The schema by which editors complete scenarios.
schema: .venv/.run
	.venv/bin/hopslam schema > scenarios/scenario.schema.json

# The site, from docs/ and from the code: site/index.html. A link that leads nowhere is an error.
docs: .venv/.docs
	NO_MKDOCS_2_WARNING=1 .venv/bin/mkdocs build --quiet
	@echo 'open site/index.html; or, to search in it too: .venv/bin/python -m http.server --bind 127.0.0.1 --directory site'

# The pictures of the README and of some pages of docs/, and the map as it grows.
pictures: .venv/.run
	.venv/bin/python docs/draw_architecture.py
	.venv/bin/python docs/draw_topics.py
	.venv/bin/python docs/draw_robot.py
	rm -rf runs/pictures
	.venv/bin/hopslam world office_loop --out docs/office_loop.png
	.venv/bin/hopslam world random_office --seed 7 --out docs/random_office.png
	.venv/bin/hopslam world campus_loop --out docs/campus_loop.png
	.venv/bin/hopslam run corridor --out runs/pictures/corridor
	cp runs/pictures/corridor/map.png docs/corridor.png
	.venv/bin/hopslam animate runs/pictures/corridor --out docs/corridor.webp
	.venv/bin/hopslam run corridor --set duration=30 --out runs/pictures/short
	.venv/bin/hopslam lines runs/pictures/short --scan 150 --sensor urg04lx --png docs/method-lines.png
	.venv/bin/hopslam run paper_simulation --seed 0 --out runs/pictures/paper
	.venv/bin/hopslam lines runs/pictures/paper --scan 100 --method paper --png docs/method-lines-paper.png
	.venv/bin/hopslam report runs/pictures/paper --figures runs/pictures/figures
	cp runs/pictures/figures/fig15.png docs/method-match.png
	cp runs/pictures/figures/fig16.png docs/method-map.png

# Versions and hashes of what `make run` and `make test` install, made anew: the newest that pyproject.toml allows.
PIN := .venv/bin/uv pip compile pyproject.toml --quiet --upgrade --universal --python-version 3.11 --generate-hashes \
    --no-header --no-annotate --no-emit-index-url --no-emit-find-links

pins: .venv/bin/pip
	.venv/bin/pip install --quiet uv
	$(PIN) --extra bench --group build --group dev --output-file pins/test.txt
	$(PIN) --group build --constraint pins/test.txt --output-file pins/run.txt

licences: .venv/.run
	.venv/bin/hopslam licences

# The wheel and the source distribution in dist/, built and checked; nothing is uploaded.
release: .venv/.run
	rm -rf dist
	.venv/bin/pip install --quiet twine
	.venv/bin/python -m hatchling build --target sdist --target wheel
	.venv/bin/twine check --strict dist/*

clean:
	rm -rf .venv .venv-ros

.venv/.run: pyproject.toml pins/run.txt .venv/bin/pip
	$(INSTALL) --require-hashes --requirement pins/run.txt
	$(INSTALL) --no-deps --no-build-isolation --editable .
	touch $@

.venv/.dev: pyproject.toml pins/test.txt .venv/bin/pip
	$(INSTALL) --require-hashes --requirement pins/test.txt
	$(INSTALL) --no-deps --no-build-isolation --editable .
	@# The hot loops are compiled once here, and not by every worker of the tests: those of SLAM, and the robots' beside.
	.venv/bin/python -c 'from sim.robot import SimRobot; from slam.scenario.file import load_scenario; import gymnasium; \
	    SimRobot(load_scenario("corridor", ["physics.engine=plan"])).observe(); \
	    envs = gymnasium.make_vec("sim:hopslam/Corridor-v0", 2, "vector_entry_point"); \
	    envs.reset(seed=0); envs.step(envs.action_space.sample())' & robots=$$!; \
	.venv/bin/python -c 'from slam.config import SlamConfig; from slam.console.terminal import Terminal; \
	    from slam.run.warm_up import warm_up; warm_up(Terminal(), SlamConfig(), search=True)' && wait $$robots
	touch $@ .venv/.run

.venv/.ros: .venv/.dev
	$(INSTALL) --no-build-isolation --editable '.[ros]'
	touch $@

ROS_WHEELS = ros-$*-rclpy ros-$*-sensor-msgs ros-$*-nav-msgs

.venv-ros/%/.done: .venv/bin/pip
	.venv/bin/python -m venv .venv-ros/$*
	.venv-ros/$*/bin/pip install --quiet $(ROS_WHEELS) $(if $(filter jazzy,$*),ros-jazzy-rmw-fastrtps-cpp,ros-rmw-fastrtps-cpp ros-fastdds)
	touch $@

.venv/.docs: pyproject.toml .venv/.run
	.venv/bin/pip install --quiet --group docs
	touch $@

# With the first whole CPython of these, 3.11 before newer ones; `make PYTHON=python3.13 run` takes that one. The pip of
# 3.11 knows no dependency groups.
PYTHON := python3.11 python3 python3.12 python3.13

.venv/bin/pip:
	@for python in $(PYTHON); do \
	    if $$python -c 'import ensurepip, sys, venv; sys.exit(not (3, 11) <= sys.version_info[:2] <= (3, 13))' 2>/dev/null; then \
	        $$python -m venv .venv && .venv/bin/python -m pip install --quiet --upgrade 'pip>=25.1' && exit 0; \
	        rm -rf .venv; exit 1; \
	    fi; \
	done; \
	if command -v uv >/dev/null 2>&1; then uv venv --quiet --seed --python 3.11 .venv && exit 0; fi; \
	echo '$(WHY)' >&2; exit 1
