"""Which experiments are there? Every package beside this file that exports ``EXPERIMENT``."""

import importlib
import pkgutil
from pathlib import Path

from bench.runner.experiment import Experiment


def find_experiments() -> dict[str, Experiment]:
    """Give all experiments by name, in their order."""
    packages = [m.name for m in pkgutil.iter_modules([str(Path(__file__).parent)]) if m.ispkg]
    found = [importlib.import_module(f"bench.experiments.{name}").EXPERIMENT for name in packages]
    return {each.name: each for each in sorted(found, key=lambda each: (each.order, each.name))}


EXPERIMENTS = find_experiments()
