"""Keys of a frame's objects that are the same in every frame.

A frame's ids are its own: ``id.object`` counts what that frame examined. What an object of the
endless field is everywhere and always is its species, its cell in the species' lattice and its
number there; its 128-bit key is a hash of those and the seed, the same in every frame that sees it.
"""

import hashlib
import struct
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from lod.pruner import Cut
from scenes.actors.performance import Cast
from scenes.render.description import object_ids
from scenes.scene import Scene, World


@dataclass(frozen=True)
class Identity:
    """One object that a frame displays.

    object  what the frame calls it in ``id.object``
    of      species, placed object, actor or terrain
    cell, index, key  its place in the endless field and its key; None of what is not of a field
    """

    object: int
    of: str
    cell: tuple[int, int] | None = None
    index: int | None = None
    key: str | None = None

    @property
    def name(self) -> str:
        """Name that is the same in every frame; what is not of a field has that of its kind."""
        if self.cell is None:
            return self.of
        return f"{self.of}_{self.cell[0]}_{self.cell[1]}_{self.index}"


def identities(scene: Scene, frame: int) -> Iterator[Identity]:
    """Identify every object that the frame displays, by the frame's own number."""
    yield from identities_in(scene.world, scene.cut(frame))


def identities_in(world: World, cuts: Sequence[Cut]) -> Iterator[Identity]:
    """Identify the objects of the cuts of a frame, one of each representation in their order."""
    fields = {each.name: each for each in world.fields}
    for each, cut, first in zip(world.representations, cuts, object_ids(cuts), strict=True):
        rows = np.unique(cut.object)
        if isinstance(each, Cast):
            yield from (Identity(first + row, each.name_of(cut, row)) for row in rows.tolist())
            continue
        if each.name not in fields:
            yield from (Identity(first + row, each.name) for row in rows.tolist())
            continue
        samples = cut.parts.state.samples
        for row in rows.tolist():
            cell = int(samples.cell_x[row]), int(samples.cell_y[row])
            index = int(samples.index[row])
            key = object_key(fields[each.name].seed, each.name, cell, index)
            yield Identity(first + row, each.name, cell, index, key)


def object_key(seed: int, species: str, cell: tuple[int, int], index: int) -> str:
    """Hash an object of the endless field to 128 bits, as 32 hexadecimal digits.

    It is BLAKE2b of the species' name (UTF-8), keyed by seed, cell x, cell y and index as four
    8-byte little-endian integers.
    """
    words = struct.pack("<Qqqq", seed, *cell, index)
    return hashlib.blake2b(species.encode(), digest_size=16, key=words).hexdigest()
