# `make demo` and `make test` do all of their set-up by themselves; see scripts/setup.sh.

python := .venv/bin/python

# A private folder for the driver where the machine gives none (scripts/setup.sh makes it).
ifeq ($(XDG_RUNTIME_DIR),)
export XDG_RUNTIME_DIR := $(CURDIR)/.venv/runtime
endif
# pyright asks the network for its newest version only to print a hint.
export PYRIGHT_PYTHON_IGNORE_WARNINGS := 1

# The theme's makers advertise its successor on every build.
export NO_MKDOCS_2_WARNING := 1

.PHONY: help demo docs test lint lock clean

help:
	@echo "make demo    render a built-in scene: picture, shadow, truth and error"
	@echo "make docs    build the documentation, warnings as errors: build/site/index.html"
	@echo "make test    lint, types and all tests"
	@echo "make lint    ruff and pyright only"
	@echo "make lock    write requirements.lock anew, with the newest versions that pyproject.toml allows"
	@echo "make clean   remove .venv and everything built"

demo:
	@scripts/setup.sh
	@$(python) -m softshadows.cli.demo

docs:
	@scripts/setup.sh --no-driver
	@$(python) -m mkdocs build --strict --quiet
	@echo "open build/site/index.html in a browser"

test: lint
	@scripts/setup.sh
	$(python) -m pytest --numprocesses auto --maxprocesses 4 --dist worksteal

lint:
	@scripts/setup.sh --no-driver
	$(python) -m ruff check .
	$(python) -m ruff format --check .
	$(python) -m pyright --pythonpath $(python)

lock:
	@scripts/lock.sh

clean:
	rm -rf .venv dist build demo .pytest_cache .ruff_cache .hypothesis
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
