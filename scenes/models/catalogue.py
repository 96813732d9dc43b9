"""What an object can be: the models that presets name, and how each is made."""

from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache

from lod.errors import InputError
from scenes.gait.gait import rest_feet
from scenes.models.animals.catalogue import KINDS, animal
from scenes.models.boulder import boulder_prototypes
from scenes.models.people.people import people_at_rest
from scenes.models.people.walking import walking_people
from scenes.models.trees.species import TreeSpecies
from scenes.models.trees.species_tables import BIRCH, BROADLEAF, CONIFER, DEAD_TREE, SHRUB
from scenes.models.trees.sway import swaying_trees
from scenes.models.trees.tree import tree_prototypes
from scenes.models.trees.weather import CALM_SUMMER, Weather
from scenes.rig.keyframes import rest_motion
from scenes.rig.rigged_prototype import RiggedPrototype
from scenes.sticks.prototype import Prototype

Made = Callable[[int, int], tuple[Prototype | RiggedPrototype, ...]]
Model = Callable[[int, int, Weather], tuple[Prototype | RiggedPrototype, ...]]


def people(seed: int, count: int) -> tuple[RiggedPrototype, ...]:
    """Adults and children, each with a walk of their own."""
    return walking_people(people_at_rest(seed, count), seed)


def one_animal(name: str) -> Made:
    """The model of a kind of animal, which comes in one build."""

    def made(seed: int, count: int) -> tuple[RiggedPrototype, ...]:
        if count != 1:
            raise InputError(
                f"{name}: prototypes", count, "animals come in one build", "set it to 1"
            )
        return (animal(name),)

    return made


def in_any_weather(made: Made) -> Model:
    """The model of what the weather does not change."""
    return lambda seed, count, _: made(seed, count)


def trees_of(species: TreeSpecies) -> Model:
    """The model of a kind of tree, as season and wind have it."""

    def made(
        seed: int, count: int, weather: Weather
    ) -> tuple[Prototype, ...] | tuple[RiggedPrototype, ...]:
        if weather.wind:
            return swaying_trees(seed, count, species, weather.season, weather.wind)
        return tree_prototypes(seed, count, species, weather.season)

    return made


MODELS: dict[str, Model] = {
    "figure": in_any_weather(people),
    "tree": trees_of(BROADLEAF),
    "birch": trees_of(BIRCH),
    "conifer": trees_of(CONIFER),
    "shrub": trees_of(SHRUB),
    "dead_tree": trees_of(DEAD_TREE),
    "boulder": in_any_weather(boulder_prototypes),
    **{name: in_any_weather(one_animal(name)) for name in KINDS},
}


def standing(prototype: RiggedPrototype) -> RiggedPrototype:
    """The same object at rest, its feet on the ground; what does not walk goes on as it does."""
    if prototype.motion.stride == 0:
        return prototype
    return prototype.with_motion(
        replace(
            rest_motion(prototype.rig),
            feet=rest_feet(prototype),
            tilts=prototype.motion.tilts,
        )
    )


SEED = 0
"""That prototypes of all worlds grow from: worlds of other seeds place the same ones elsewhere."""


@lru_cache(maxsize=64)
def made(
    model: str,
    count: int,
    sizes: tuple[float, ...],
    walks: bool,
    weather: Weather = CALM_SUMMER,
) -> tuple[Prototype | RiggedPrototype, ...]:
    """Every prototype of a model in every size, walking or standing."""
    prototypes = MODELS[model](SEED, count, weather)
    if not walks:
        prototypes = tuple(standing(p) if isinstance(p, RiggedPrototype) else p for p in prototypes)
    return tuple(p.scaled(size) for p in prototypes for size in sizes)
