"""Event-driven dynamics of hard ellipsoids. Names are loaded when first used, so that `import edmd` and `edmd --help` are quick."""

import importlib

__version__ = "0.1.0"

_HOMES = {"System": "system", "Simulation": "simulation", "Stalled": "stall", "lattice": "initial", "from_ase": "initial",
          "random_system": "initial", "thermalized": "velocities", "pack": "packing", "Packing": "packing", "Trajectory": "trajectory",
          "read_system": "exchange", "export": "exchange", "run": "runs", "resume": "runs", "RunComplete": "runs", "read_config": "config",
          "config_text": "config", "Observer": "observers", "Schedule": "observers", "Every": "observers", "Logarithmic": "observers",
          "Milestones": "observers", "sweep": "sweeps.campaign", "random_points": "sweeps.design", "Elastic": "rules.kinds",
          "Inelastic": "rules.kinds", "Viscoelastic": "rules.kinds", "PowerLaw": "rules.kinds", "Rough": "rules.kinds"}
__all__ = ["__version__", *_HOMES]


def __getattr__(name):
    if name not in _HOMES:
        raise AttributeError(f"module 'edmd' has no attribute {name!r}")
    return getattr(importlib.import_module(f"edmd.{_HOMES[name]}"), name)


def __dir__():
    return sorted(__all__)
