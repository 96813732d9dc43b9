"""Which experiments can `lodbench run` measure and judge? Every package beside this file.

Each package exports one object, ``EXPERIMENT``, whose claims the report shows. Studies, which are
programs of their own without records and claims, are in ``bench.studies.registry``.
"""

import importlib
import pkgutil
from pathlib import Path

from bench.runner.experiment import Experiment


def find_experiments() -> dict[str, Experiment]:
    """Import every package beside this file, and return its experiment by name, in their order."""
    packages = [m.name for m in pkgutil.iter_modules([str(Path(__file__).parent)]) if m.ispkg]
    found = [importlib.import_module(f"bench.experiments.{name}").EXPERIMENT for name in packages]
    return {each.name: each for each in sorted(found, key=lambda each: (each.order, each.name))}


EXPERIMENTS = find_experiments()
"""All experiments by name, in the order of lists and reports."""
