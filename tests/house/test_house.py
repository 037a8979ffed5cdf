"""The rules of the house (docs/architecture.md): what imports what, how long a file is, how quick the command line, how fresh the cache."""

import ast
import importlib.util
import json
import os
import resource
import shutil
import subprocess
import sys
import tomllib
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PACKAGES = ("ccd", "edmd", "analysis")
HEAVY = ("numba", "numpy", "scipy", "h5py", "ase", "MDAnalysis", "matplotlib", "tqdm")
LONGEST_FILE = 450              # lines
QUICK = 0.2                     # CPU seconds for `edmd --help`
SOURCES = sorted(path for package in PACKAGES for path in (ROOT / package).rglob("*.py"))


def module_name(path, root=ROOT):
    return ".".join(path.relative_to(root).with_suffix("").parts).removesuffix(".__init__")


def python(*arguments, **environment):
    return subprocess.run([sys.executable, *arguments], cwd=ROOT, env=os.environ | {"PYTHONPATH": str(ROOT)} | environment,
                          capture_output=True, text=True, timeout=120, check=False)


def test_imports_keep_the_contracts_of_pyproject():
    assert "[[tool.importlinter.contracts]]" in (ROOT / "pyproject.toml").read_text()
    done = python("-c", "from importlinter.cli import lint_imports_command; lint_imports_command()", "--no-cache", "--no-logo")
    assert done.returncode == 0, done.stdout + done.stderr
    assert "0 broken" in done.stdout


@pytest.mark.parametrize("path", SOURCES, ids=module_name)
def test_no_file_is_too_long_to_read(path):
    assert len(path.read_text().splitlines()) <= LONGEST_FILE


# the command line

def test_help_imports_nothing_heavy():
    done = python("-c", "import sys, edmd.cli\ntry:\n    edmd.cli.main(['--help'])\nexcept SystemExit as end:\n    assert not end.code\n"
                        "print('LOADED', *sys.modules)")
    assert done.returncode == 0, done.stderr
    help_text, loaded = done.stdout.split("LOADED")
    assert "usage: edmd" in help_text
    assert {name.split(".")[0] for name in loaded.split()}.isdisjoint(HEAVY)


def test_help_answers_at_once():
    def seconds():
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        assert python("-m", "edmd", "--help").returncode == 0
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    assert min(seconds() for _ in range(3)) < QUICK


# compiled code

@pytest.fixture
def copied(tmp_path):
    """A copy of the packages, where a test may edit."""
    for package in PACKAGES:
        shutil.copytree(ROOT / package, tmp_path / "copy" / package, ignore=shutil.ignore_patterns("__pycache__"))
    return tmp_path / "copy"


def cache_name(copied, monkeypatch, package="edmd"):
    """The cache folder that a fresh process with these sources would use."""
    monkeypatch.setenv("EDMD_CACHE_DIR", str(copied.parent / "cache"))
    spec = importlib.util.spec_from_file_location("cache_of_the_copy", copied / "ccd" / "code_cache.py")
    code_cache = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(code_cache)
    return code_cache.cache_folder(package)


def edit(path):
    path.write_text(path.read_text() + "\nEDITED = 1\n")


@pytest.mark.parametrize(("file", "edmd_too"), [
    ("ccd/tolerances.py", True), ("ccd/vectors.py", True), ("ccd/status.py", True), ("edmd/tolerances.py", True), ("edmd/state.py", True),
    ("edmd/engine.py", True), ("edmd/rules/elastic.py", True), ("edmd/cli.py", False), ("edmd/trajectory.py", False),
    ("analysis/reader.py", False),
])
def test_compiled_code_is_keyed_to_all_it_was_compiled_from_and_no_more(copied, monkeypatch, file, edmd_too):
    before = cache_name(copied, monkeypatch)
    assert cache_name(copied, monkeypatch) == before
    edit(copied / file)
    assert (cache_name(copied, monkeypatch) != before) == edmd_too


def test_a_constant_changed_in_place_opens_a_new_cache_for_both_floors(copied, monkeypatch):
    before = [cache_name(copied, monkeypatch, package) for package in ("ccd", "edmd")]
    path = copied / "ccd" / "tolerances.py"
    path.write_text(path.read_text().replace("PENCIL_STEPS = ", "PENCIL_STEPS = 1 + ", 1))
    after = [cache_name(copied, monkeypatch, package) for package in ("ccd", "edmd")]
    assert len({*before, *after}) == 4


def imported(path, files):
    """Modules of these packages that a file imports at its top level, read by Python's own parser."""
    for node in ast.parse(path.read_text()).body:
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            submodules = [f"{node.module}.{alias.name}" for alias in node.names]
            yield from (name if name in files else node.module for name in submodules)


@pytest.mark.parametrize("package", PACKAGES)
def test_every_import_of_a_kernel_file_counts_for_its_cache(package):
    from ccd.code_cache import kernel_sources

    files = {module_name(path): path for path in SOURCES}
    reached = {name for name, path in files.items() if name.startswith(package) and any(
        isinstance(node, ast.FunctionDef) and any(getattr(d, "id", "") in ("kernel", "parallel_kernel") for d in node.decorator_list)
        for node in ast.parse(path.read_text()).body)}
    assert reached
    frontier = list(reached)
    while frontier:
        new = {name for name in imported(files[frontier.pop()], files) if name in files} - reached
        reached |= new
        frontier += new
    assert reached <= set(kernel_sources(package))


@pytest.mark.parametrize(("statement", "file"), [
    ("from edmd.added import NUMBER", "edmd/added.py"),
    ("from edmd import added", "edmd/added.py"),
    ("from edmd import (\n    added,\n    state,\n)", "edmd/added.py"),
    ("import edmd.added", "edmd/added.py"),
    ("from edmd.rules import NUMBER", "edmd/rules/__init__.py"),
])
def test_the_cache_follows_imports_however_they_are_written(copied, monkeypatch, statement, file):
    (copied / "edmd" / "added.py").write_text("NUMBER = 1\n")
    path = copied / "edmd" / "collision.py"
    path.write_text(f"{statement}\n{path.read_text()}")
    before = cache_name(copied, monkeypatch)
    edit(copied / file)
    assert cache_name(copied, monkeypatch) != before


def test_processes_that_begin_together_compile_once(tmp_path):
    code = """
from ccd.separation import best_plane_of
sphere = (1.0, 1.0, 1.0, 0.0, 0.0, 0.0)
best_plane_of(sphere, sphere, (3.0, 0.0, 0.0), 0.5, 1e-5)
print(sum(best_plane_of.entry.stats.cache_misses.values()))
"""
    running = [subprocess.Popen([sys.executable, "-c", code], cwd=ROOT, stdout=subprocess.PIPE, text=True,
                                env=os.environ | {"PYTHONPATH": str(ROOT), "EDMD_CACHE_DIR": str(tmp_path)}) for _ in range(3)]
    assert sorted(each.communicate(timeout=120)[0].strip() for each in running) == ["0", "0", "1"]


def test_the_engine_is_compiled_for_one_kind_of_world_only():
    """A second signature is a second engine: compiled again, for an array that is strided, read-only or of another type."""
    done = python("-c", """
import json
import edmd, numpy as np
system = edmd.lattice("fcc", (1.0, 1.0, 1.5), 0.35, cells=(3, 3, 3), seed=1)
simulation = edmd.Simulation(system)
simulation.run(collisions=300)
simulation.run(time=0.01)
simulation.compress(0.1, until_packing_fraction=0.36)
strided = edmd.System(np.asfortranarray(system.positions), np.repeat(system.orientations, 2, axis=0)[::2],
                      np.float32([1, 1, 1.5]), system.box, system.velocities)
strided.velocities.flags.writeable = False
edmd.Simulation(strided).run(collisions=50)
from edmd import engine, epoch
called_from_python = [engine.advance_events, epoch.start_epoch, epoch.kinetic_energy, epoch.rescale, epoch.forget_lists, epoch.make_lists,
                      epoch.reschedule_all, epoch.set_growth]
print(json.dumps({kernel.__name__: len(kernel.entry.signatures) for kernel in called_from_python}))
""")
    assert done.returncode == 0, done.stderr
    counts = json.loads(done.stdout)
    assert counts["advance_events"] == 1
    assert {name: count for name, count in counts.items() if count > 1} == {}


# the vocabulary

def members():
    from ccd import State, Status
    from edmd.events import Ended, EventKind
    from edmd.rules.kinds import RuleKind

    return [(kind, member.name) for kind in (EventKind, Ended, RuleKind, State, Status) for member in kind]


def test_every_folder_of_tests_is_run():
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["pytest"]["ini_options"]
    assert {ROOT / path for path in settings["testpaths"]} == {path.parent for path in (ROOT / "tests").rglob("test_*.py")}


def test_every_rule_has_its_file_and_its_line_in_the_docs():
    from edmd.rules.kinds import RuleKind

    told = (ROOT / "docs" / "granular.md").read_text()
    for rule in RuleKind:
        assert (ROOT / "edmd" / "rules" / f"{rule.name.lower()}.py").exists()
        assert f'"{rule.name.lower()}"' in told, f"{rule.name} is not in docs/granular.md"


@cache
def attributes_named(path):
    """(name, attribute) of each attribute of a plain name in a file."""
    return {(node.value.id, node.attr) for node in ast.walk(ast.parse(path.read_text()))
            if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name)}


@pytest.mark.parametrize(("kind", "name"), members(), ids=lambda value: value if isinstance(value, str) else value.__name__)
def test_every_word_of_the_vocabulary_is_spoken(kind, name):
    """A member of an enum has its branch somewhere in the code: a member that nobody names is dead, or a forgotten case."""
    defined = None if kind.__name__ == "RuleKind" else Path(sys.modules[kind.__module__].__file__)     # rules: side by side
    spoken = [path for path in SOURCES if path != defined and (kind.__name__, name) in attributes_named(path)]
    assert spoken, f"no code names {kind.__name__}.{name}"
