# `make demo` packs ellipsoids and draws them; `make test` runs the tests, `make docs` builds the site. All make their own environment in .venv.
PYTHON ?= python3
BIN := .venv/bin
DEMO ?=

.PHONY: demo test validate lint docs clean

.venv/installed: pyproject.toml
	$(PYTHON) -m venv .venv
	$(BIN)/pip install --quiet --disable-pip-version-check --editable .
	touch $@

.venv/installed-for-tests: .venv/installed
	$(BIN)/pip install --quiet --disable-pip-version-check --editable '.[test]'
	touch $@

.venv/installed-for-docs: .venv/installed
	$(BIN)/pip install --quiet --disable-pip-version-check --editable '.[docs]'
	touch $@

demo: .venv/installed
	$(BIN)/python examples/demo.py $(DEMO)

test: .venv/installed-for-tests
	$(BIN)/python -m pytest -n auto --dist worksteal

validate: .venv/installed-for-tests
	$(BIN)/python -m pytest -m validate

lint: .venv/installed-for-tests
	$(BIN)/ruff check .
	$(BIN)/lint-imports
	$(BIN)/mypy --no-error-summary

docs: .venv/installed-for-docs
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --quiet

clean:
	rm -rf .venv demo cooling boxers robot_arm ccd_equation compression_rates packing_by_aspect_ratio isotropic_to_nematic \
		equation_of_state crystal_from_ase contacts_of_a_frame build site *.egg-info .pytest_cache .hypothesis .ruff_cache .import_linter_cache .mypy_cache
