"""What a type checker sees of the names that edmd/__init__.py loads when they are first used."""

from edmd.config import config_text as config_text
from edmd.config import read_config as read_config
from edmd.exchange import export as export
from edmd.exchange import read_system as read_system
from edmd.initial import from_ase as from_ase
from edmd.initial import lattice as lattice
from edmd.initial import random_system as random_system
from edmd.observers import Every as Every
from edmd.observers import Logarithmic as Logarithmic
from edmd.observers import Milestones as Milestones
from edmd.observers import Observer as Observer
from edmd.observers import Schedule as Schedule
from edmd.packing import Packing as Packing
from edmd.packing import pack as pack
from edmd.rules.elastic import Elastic as Elastic
from edmd.rules.inelastic import Inelastic as Inelastic
from edmd.rules.power_law import PowerLaw as PowerLaw
from edmd.rules.rough import Rough as Rough
from edmd.rules.viscoelastic import Viscoelastic as Viscoelastic
from edmd.runs import RunComplete as RunComplete
from edmd.runs import resume as resume
from edmd.runs import run as run
from edmd.simulation import Simulation as Simulation
from edmd.stall import Stalled as Stalled
from edmd.sweeps.campaign import sweep as sweep
from edmd.sweeps.design import random_points as random_points
from edmd.system import System as System
from edmd.trajectory import Trajectory as Trajectory
from edmd.velocities import thermalized as thermalized

__version__: str
