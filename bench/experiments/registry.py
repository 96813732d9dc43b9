"""Which experiments can `lodbench run` measure and judge? Every package below this folder.

Each package exports one object, ``EXPERIMENT``, whose claims the report shows; a package within
one is an experiment of its own on the same subject. Studies, which are programs of their own
without records and claims, are in ``bench.studies.registry``.
"""

import importlib
import pkgutil
from pathlib import Path

from bench.runner.experiment import Experiment

_HERE = "bench.experiments."


def find_experiments() -> dict[str, Experiment]:
    """Import every package below this folder; return their experiments by name, in their order."""
    modules = pkgutil.walk_packages([str(Path(__file__).parent)], _HERE)
    found = [importlib.import_module(each.name).EXPERIMENT for each in modules if each.ispkg]
    return {each.name: each for each in sorted(found, key=lambda each: (each.order, each.name))}


EXPERIMENTS = find_experiments()
"""All experiments by name, in the order of lists and reports."""
