"""The models that presets name, and the prototypes of each.

A species of tree or an animal is a model by its file being there (``scenes.model_files``).
What makes a model is imported when it is made, for prototypes are kept from one run to the next.
"""

from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache

from lod.errors import InputError
from scenes.model_files import animal_names, tree_species_names
from scenes.processes.cache import content_key, kept_data
from scenes.processes.progress import steps, tell
from scenes.rig.rig import rest_motion
from scenes.rig.rigged_prototype import RiggedPrototype
from scenes.sticks.prototype import Prototype
from scenes.trees.species import CALM_SUMMER, Weather

Prototypes = tuple[Prototype | RiggedPrototype, ...]
Model = Callable[[int, int, Weather], Prototypes]
"""What makes so many prototypes from a seed and a count, for a weather."""


def people(seed: int, count: int, _: Weather = CALM_SUMMER) -> tuple[RiggedPrototype, ...]:
    """Make adults and children, each with a walk of their own."""
    from scenes.figures.animal_file import people_at_rest, walking_people

    return walking_people(people_at_rest(seed, count), seed)


def _boulders(seed: int, count: int, _: Weather) -> Prototypes:
    from scenes.models.stone import boulder_prototypes

    return boulder_prototypes(seed, count)


def _sward(seed: int, count: int, weather: Weather) -> Prototypes:
    from scenes.grass.sward import swards

    return swards(seed, count, weather)


def _tree(name: str) -> Model:
    def build(seed: int, count: int, weather: Weather) -> Prototypes:
        from scenes.trees.species import tree_species
        from scenes.trees.tree import swaying_trees, tree_prototypes

        species = tree_species(name)
        if weather.wind:
            return swaying_trees(seed, count, species, weather.season, weather.wind)
        return tree_prototypes(seed, count, species, weather.season)

    return build


def _animal(name: str) -> Model:
    def build(seed: int, count: int, _: Weather) -> Prototypes:
        from scenes.figures.animal_file import animal

        _refuse_several(name, count, "animals")
        return (animal(name),)

    return build


def _imported(name: str, sha256: str) -> Model:
    def build(seed: int, count: int, _: Weather) -> Prototypes:
        from scenes.imported.imported_prototype import imported_prototype
        from scenes.imported.library import model_by_digest

        _refuse_several(name, count, "imported models")
        return (imported_prototype(name, model_by_digest("model", name, sha256)),)

    return build


def _refuse_several(name: str, count: int, kind: str) -> None:
    if count != 1:
        raise InputError(f"{name}: prototypes", count, f"{kind} come in one build", "set it to 1")


MODELS: dict[str, Model] = {
    "figure": people,
    **{name: _tree(name) for name in tree_species_names()},
    "boulder": _boulders,
    "sward": _sward,
    **{name: _animal(name) for name in animal_names()},
}


def at_rest(prototype: RiggedPrototype) -> RiggedPrototype:
    """Return a walker at rest, its feet on the ground; other objects keep their motion."""
    from scenes.figures.gait import rest_feet

    if prototype.motion.stride == 0:
        return prototype
    still, tilts = rest_motion(prototype.rig), prototype.motion.tilts
    return replace(prototype, motion=replace(still, feet=rest_feet(prototype), tilts=tilts))


PROTOTYPE_SEED = 0
"""Seed of prototypes: worlds of different seeds place the same prototypes elsewhere, unless theirs
is another, too."""


@lru_cache(maxsize=64)
def model_prototypes(
    model: str,
    count: int,
    sizes: tuple[float, ...],
    walks: bool,
    weather: Weather = CALM_SUMMER,
    sha256: str | None = None,
    seed: int = PROTOTYPE_SEED,
) -> Prototypes:
    """Make every prototype of a model in every size, walking or standing; kept for later runs.

    sha256: hash of an imported model; None for those that come with the program
    seed: every seed gives other individuals of the model; an imported one has none
    """

    def make() -> Prototypes:
        tell()
        build = MODELS[model] if sha256 is None else _imported(model, sha256)
        made = build(seed, count, weather)
        if not walks:
            made = tuple(at_rest(p) if isinstance(p, RiggedPrototype) else p for p in made)
        each_size = tuple(p.scaled(size) for p in made for size in sizes)
        if model != "sward":
            return each_size
        from scenes.grass.sward import ranked

        return tuple(each for tuft in each_size for each in ranked(tuft))

    key = content_key(model, seed, count, sizes, walks, weather, sha256)
    with steps(count):
        return kept_data("prototypes", key, make)
