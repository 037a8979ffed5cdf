"""What is swept, a config or a Python function: which parameters it takes, and the task of one run, as JSON holds it."""

import inspect
import sys
from pathlib import Path

from edmd.config import document_of, only_known, put, read_config
from edmd.sweeps.design import plain

OWN = ("seed", "directory")             # what a sweep gives to every run, if it wants it


def subject_of(function_or_config):
    return Function(function_or_config) if callable(function_or_config) else Recipe(function_or_config)


class Recipe:
    """A config of `edmd run`; parameters are its keys, joined by dots."""

    def __init__(self, config):
        self._document = plain("config", document_of(config))
        self.identity = {"config": self._document}

    def task(self, planned):
        _check_own(planned, ("seed", "output.file"))
        document = document_of(self._document)
        for key, value in planned.parameters.items():
            put(document, key, value)
        document["seed"] = planned.seed
        read_config(document)
        return {"config": document}


class Function:
    """A function at the top of a module or script, which takes parameters, and `seed` and `directory` (a Path) where it names them, and
    returns a dict of numbers."""

    def __init__(self, function):
        name, module = getattr(function, "__qualname__", ""), sys.modules.get(getattr(function, "__module__", ""))
        file = getattr(module, "__file__", None)
        if getattr(module, name, None) is not function or file is None:
            raise ValueError(f"function = {function!r}: expected a function at the top of a module or script, which another process can "
                             "import")
        place = Path(file).resolve()
        home = module.__name__ if module.__name__ != "__main__" else getattr(module.__spec__, "name", None)     # None: a script
        depth = home.count(".") + (place.name == "__init__.py") if home else 0
        self._task = {"function": name, "module": home, "file": str(place), "path": str(place.parents[depth])}
        self.identity = {"function": f"{home or place.name}:{name}"}
        self._takes = inspect.signature(function).parameters

    def task(self, planned):
        _check_own(planned, OWN)
        kinds = {parameter.kind for parameter in self._takes.values()}
        takes = [name for name in self._takes if name not in OWN]
        if inspect.Parameter.VAR_KEYWORD not in kinds:
            only_known("", planned.parameters, takes)
        missing = [name for name in takes if name not in planned.parameters and self._takes[name].default is inspect.Parameter.empty
                   and self._takes[name].kind in (inspect.Parameter.POSITIONAL_OR_KEYWORD, inspect.Parameter.KEYWORD_ONLY)]
        if missing:
            raise ValueError(f"{missing[0]}: the function needs it; expected it in the grid, beside {', '.join(planned.parameters)}")
        given = [own for own in OWN if own in self._takes or inspect.Parameter.VAR_KEYWORD in kinds]
        return self._task | {"given": given}


def _check_own(planned, own):
    for name in own:
        if name in planned.parameters:
            raise ValueError(f"{name}: every run of a sweep has its own; expected replicas, and the seed of the sweep, instead")
