"""Animals, and the paper's two doubtful cases, an insect and an artifact (§2.3), as posable
prototypes.

Blake conjectures that parts shrink with depth in the hierarchy for living things of about our size
alone: insects and artifacts are here to put that to the test.
"""

from functools import lru_cache

from lod.errors import InputError
from scenes.gait.gait import with_gait
from scenes.models.animals.giraffe import GIRAFFE
from scenes.models.animals.kind import Kind
from scenes.models.animals.ostrich import OSTRICH
from scenes.models.animals.rabbit import RABBIT
from scenes.models.animals.stick_insect import INSECT
from scenes.models.animals.windmill import WINDMILL
from scenes.rig.build import build_prototype
from scenes.rig.rigged_prototype import RiggedPrototype

KINDS: dict[str, Kind] = {
    "rabbit": RABBIT,
    "giraffe": GIRAFFE,
    "ostrich": OSTRICH,
    "insect": INSECT,
    "windmill": WINDMILL,
}


def kind_named(name: str) -> Kind:
    """The kind of that name. Raises InputError for an unknown one."""
    if name not in KINDS:
        raise InputError("animal", name, f"one of {', '.join(KINDS)}")
    return KINDS[name]


@lru_cache(maxsize=16)
def animal(name: str) -> RiggedPrototype:
    """One of ``KINDS``, walking, hopping or turning."""
    kind = kind_named(name)
    return with_gait(build_prototype(name, kind.anatomy, kind.build), kind.gait)


def parts_of_kind(name: str) -> tuple[str, ...]:
    """Names of its parts, in the order of its hierarchy."""
    return kind_named(name).anatomy.part_names
