"""Which objects are judged: trees and imported models that nothing was fitted to, and our own.

The trees are of the kinds in ``kinds`` beside this file and of the project's own species; those of
two seeds that no preset uses stand beside the presets' own. The imported models are those of the
tests, frozen. People have leaf appearances that were chosen otherwise.
"""

from dataclasses import dataclass
from importlib import resources
from pathlib import Path

from scenes.model_files.names import tree_species_names
from scenes.models.catalogue import MODELS, PROTOTYPE_SEED, at_rest
from scenes.rig.rigged_prototype import RiggedPrototype
from scenes.sticks.prototype import Prototype
from scenes.trees.species import CALM_SUMMER, TreeSpecies, read_species, tree_species
from scenes.trees.tree import tree_prototypes

UNSEEN = ("poplar", "acacia", "pine")
"""Kinds of tree whose parameters were frozen before the fit that they judge."""

UNSEEN_SEEDS = (71, 72)
"""Seeds that no preset uses."""

IMPORTED = {"mill": "mill.usda", "lamp_tree": "lamp_tree.glb"}
"""Imported models of five levels, by the names of their files."""

OTHERS = ("figure", "boulder")
"""Models that are no trees."""

KINDS = Path(str(resources.files("bench.studies.appearance"))) / "kinds"


@dataclass(frozen=True)
class Case:
    """One object: the name of its kind, and the seed that it grew from."""

    kind: str
    seed: int

    @property
    def title(self) -> str:
        """Name the object in tables."""
        return self.kind if self.kind in IMPORTED else f"{self.kind}, seed {self.seed}"


def cases() -> list[Case]:
    """Return what is judged: unseen kinds, imported models, unseen seeds, and what presets have."""
    own = tree_species_names()
    found = [Case(kind, UNSEEN_SEEDS[0]) for kind in UNSEEN]
    found += [Case(kind, PROTOTYPE_SEED) for kind in IMPORTED]
    found += [Case(kind, seed) for seed in UNSEEN_SEEDS for kind in own]
    return found + [Case(kind, PROTOTYPE_SEED) for kind in (*own, *OTHERS)]


def species_of(kind: str) -> TreeSpecies:
    """Return the species of a kind of this study, or of the project's own of that name."""
    return read_species(KINDS / f"{kind}.toml") if kind in UNSEEN else tree_species(kind)


def prototype_of(case: Case) -> Prototype | RiggedPrototype:
    """Make the object of a case, in summer and at rest."""
    if case.kind in IMPORTED:
        from scenes.imported.imported_prototype import imported_prototype
        from scenes.imported.library import read_model

        return imported_prototype(case.kind, read_model(KINDS / IMPORTED[case.kind]))
    if case.kind in OTHERS:
        (made,) = MODELS[case.kind](case.seed, 1, CALM_SUMMER)
        return at_rest(made) if isinstance(made, RiggedPrototype) else made
    return tree_prototypes(case.seed, 1, species_of(case.kind))[0]
