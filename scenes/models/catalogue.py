"""The models that presets name, and the prototypes of each.

A species of tree or an animal is a model by its file being there (``scenes.model_files.names``).
What makes a model is imported when it is made, for prototypes are kept from one run to the next.
"""

from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache

from lod.errors import InputError
from scenes.model_files.names import animal_names, tree_species_names
from scenes.processes.cache import content_key, kept_data
from scenes.processes.progress import steps, tell
from scenes.rig.rig import rest_motion
from scenes.rig.rigged_prototype import RiggedPrototype
from scenes.sticks.prototype import Prototype
from scenes.trees.species import CALM_SUMMER, Weather

WeatherlessModel = Callable[[int, int], tuple[Prototype | RiggedPrototype, ...]]
Model = Callable[[int, int, Weather], tuple[Prototype | RiggedPrototype, ...]]


def people(seed: int, count: int) -> tuple[RiggedPrototype, ...]:
    """Make adults and children, each with a walk of their own."""
    from scenes.figures.person import people_at_rest, walking_people

    return walking_people(people_at_rest(seed, count), seed)


def animal_model(name: str) -> WeatherlessModel:
    """Return the model of a kind of animal, which comes in one build."""

    def build(seed: int, count: int) -> tuple[RiggedPrototype, ...]:
        from scenes.figures.animal_file import animal

        if count != 1:
            raise InputError(
                f"{name}: prototypes", count, "animals come in one build", "set it to 1"
            )
        return (animal(name),)

    return build


def in_any_weather(build: WeatherlessModel) -> Model:
    """Return the model of an object that looks the same in every season and wind."""
    return lambda seed, count, _: build(seed, count)


def tree_model(name: str) -> Model:
    """Return the model of a species of tree, in each season, still or swaying in the wind."""

    def build(
        seed: int, count: int, weather: Weather
    ) -> tuple[Prototype, ...] | tuple[RiggedPrototype, ...]:
        from scenes.trees.species import tree_species
        from scenes.trees.tree import swaying_trees, tree_prototypes

        species = tree_species(name)
        if weather.wind:
            return swaying_trees(seed, count, species, weather.season, weather.wind)
        return tree_prototypes(seed, count, species, weather.season)

    return build


def boulders(seed: int, count: int) -> tuple[Prototype, ...]:
    """Make boulders of several shapes."""
    from scenes.models.stone import boulder_prototypes

    return boulder_prototypes(seed, count)


def sward(seed: int, count: int, weather: Weather) -> tuple[Prototype | RiggedPrototype, ...]:
    """Make tufts of grass, green or dry by season, still or moving in the wind."""
    from scenes.grass.sward import swards

    return swards(seed, count, weather)


def imported_model(name: str, sha256: str) -> Model:
    """Return the imported model of that hash, which comes in one build."""

    def build(seed: int, count: int) -> tuple[RiggedPrototype, ...]:
        if count != 1:
            rule, cure = "imported models come in one build", "set it to 1"
            raise InputError(f"{name}: prototypes", count, rule, cure)
        from scenes.imported.imported_prototype import imported_prototype
        from scenes.imported.library import model_by_digest

        return (imported_prototype(name, model_by_digest("model", name, sha256)),)

    return in_any_weather(build)


MODELS: dict[str, Model] = {
    "figure": in_any_weather(people),
    **{name: tree_model(name) for name in tree_species_names()},
    "boulder": in_any_weather(boulders),
    "sward": sward,
    **{name: in_any_weather(animal_model(name)) for name in animal_names()},
}


def at_rest(prototype: RiggedPrototype) -> RiggedPrototype:
    """Return a walker at rest, its feet on the ground; other objects keep their motion."""
    from scenes.figures.gait import rest_feet

    if prototype.motion.stride == 0:
        return prototype
    return prototype.with_motion(
        replace(
            rest_motion(prototype.rig),
            feet=rest_feet(prototype),
            tilts=prototype.motion.tilts,
        )
    )


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
) -> tuple[Prototype | RiggedPrototype, ...]:
    """Make every prototype of a model in every size, walking or standing; kept for later runs.

    sha256: hash of an imported model; None for those that come with the program
    seed: every seed gives other individuals of the model; an imported one has none
    """

    def make() -> tuple[Prototype | RiggedPrototype, ...]:
        tell()
        build = MODELS[model] if sha256 is None else imported_model(model, sha256)
        made = build(seed, count, weather)
        if not walks:
            made = tuple(at_rest(p) if isinstance(p, RiggedPrototype) else p for p in made)
        return tuple(p.scaled(size) for p in made for size in sizes)

    key = content_key(model, seed, count, sizes, walks, weather, sha256)
    with steps(count):
        return kept_data("prototypes", key, make)
