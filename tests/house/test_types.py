"""Type hints: every public callable says what it takes and returns, and type checkers see what loads late. `make lint` runs mypy."""

import ast
import enum
import inspect
from pathlib import Path

import pytest

import analysis
import ccd
import edmd

OURS = ("ccd", "edmd", "analysis")


def public():
    """All public callables: (their name, the function)."""
    for package in (ccd, ccd.batch, ccd.scene, edmd, analysis):
        exported = getattr(package, "__all__", None) or [
            name for name, value in vars(package).items()
            if not name.startswith("_") and getattr(value, "__module__", "") == package.__name__]
        for name in exported:
            value = getattr(package, name)
            if inspect.isclass(value):
                yield from methods(f"{package.__name__}.{name}", value)
            elif callable(value):
                yield f"{package.__name__}.{name}", value


def methods(name, kind):
    """Its constructor, public methods and properties, those inherited from our own classes too."""
    if issubclass(kind, enum.Enum):
        return
    for base in reversed(kind.__mro__):
        if base.__module__.split(".")[0] not in OURS:
            continue
        for key, value in vars(base).items():
            value = getattr(value, "__func__", getattr(value, "fget", getattr(value, "func", value)))
            if inspect.isfunction(value) and (not key.startswith("_") or key == "__init__"):
                yield f"{name}.{key}", value


def without_hints(function):
    """What has no annotation: names of arguments, or "return"."""
    signature = inspect.signature(function)
    bare = [name for name, parameter in signature.parameters.items()
            if parameter.annotation is parameter.empty and name not in ("self", "cls")]
    return bare + ["return"] * (signature.return_annotation is signature.empty and function.__name__ != "__init__")


CALLABLES = dict(public())


def test_the_public_callables_are_found():
    assert {"ccd.first_contact", "ccd.Ellipsoid.__init__", "ccd.Ellipsoid.inertia", "ccd.batch.state", "edmd.Simulation.run",
            "edmd.Simulation.pressure", "edmd.sweep", "edmd.System.to_ase", "analysis.panels", "analysis.NearContacts.__init__"} <= set(
        CALLABLES)


def test_every_public_callable_says_what_it_takes_and_returns():
    bare = {name: without_hints(one) for name, one in CALLABLES.items()}
    assert {name: missing for name, missing in bare.items() if missing} == {}


def test_a_type_checker_sees_the_names_that_load_late():
    stub = ast.parse((Path(edmd.__file__).parent / "__init__.pyi").read_text())
    assert {alias.name for node in stub.body if isinstance(node, ast.ImportFrom) for alias in node.names} == set(edmd._HOMES)
    source = ast.parse(Path(analysis.__file__).read_text())
    checked = next(node for node in source.body if isinstance(node, ast.If))
    assert {alias.name for node in checked.body for alias in node.names} == set(analysis._DRAWING)


@pytest.mark.parametrize("package", OURS)
def test_the_packages_say_that_they_are_typed(package):
    assert (Path(__file__).parents[2] / package / "py.typed").exists()
