"""The objects of a field, drawn one by one with NumPy's own Philox, and what a cut has of them."""

import math

import numpy as np
from numpy.random import Philox

from lod.camera import GRID_M
from lod.pruner import prune
from scenes.field.cells import PoissonCells
from scenes.field.prototypes import InstancesInView
from scenes.noise import hash_name


class Waves:
    """Ground with a closed form: slopes of up to 1 in 5 at amplitude 1.5."""

    def __init__(self, amplitude):
        self.amplitude = amplitude

    def height(self, corner, xy):
        absolute = xy + GRID_M * np.array((corner.x, corner.y))
        return self.amplitude * np.sin(absolute[:, 0] / 9) * np.cos(absolute[:, 1] / 11)

    def bounds(self):
        return -self.amplitude, self.amplitude


def drawn(field, lows, highs):
    """Objects of a range of cells: key, home [m], eight uniform numbers."""
    side = PoissonCells(field.seed, field.species.name, field.species.density).side_m
    mean = field.species.density * side**2
    key = np.array((field.seed, hash_name(field.species.name)), np.uint64)

    def block(x, y, number, half):
        counter = (x % 2**64) | (y % 2**64) << 64 | number << 128 | half << 192
        before = [((counter - 1) % 2**256 >> 64 * k) % 2**64 for k in range(4)]
        words = Philox(counter=np.array(before, np.uint64), key=key).random_raw(4)
        return [(int(word) >> 11) / 2**53 for word in words]

    for x in range(lows[0], highs[0] + 1):
        for y in range(lows[1], highs[1] + 1):
            chance, count, term = block(x, y, 0, 0)[0], 0, math.exp(-mean)
            while chance >= term:
                chance, count = chance - term, count + 1
                term *= mean / count
            for number in range(count):
                u = block(x, y, number + 1, 0) + block(x, y, number + 1, 1)
                yield (x, y, number), ((x + u[0]) * side, (y + u[1]) * side), u


def objects_in(field):
    """Everything that has its home in the window, wherever it walks."""
    side = PoissonCells(0, "", field.species.density).side_m
    most = math.ceil(field.extent / side) + 1
    for each in drawn(field, (-most, -most), (most, most)):
        if max(map(abs, each[1])) <= field.extent / 2:
            yield each


def pruned(field, view):
    """The cut, and what is displayed as (object, prototype, part)."""
    cut = prune(field, view)
    parts, objects = cut.parts, cut.parts.state
    variant = objects.instances.prototype[parts.object]
    samples, first = objects.samples, field.prototypes.part_tables.root
    found = {
        (
            (int(samples.cell_x[o]), int(samples.cell_y[o]), int(samples.index[o])),
            v,
            int(p - first[v]),
        )
        for o, p, v in zip(parts.object, parts.part, variant.tolist(), strict=True)
    }
    assert len(found) == cut.displayed_parts
    return cut, found


def instances_in_cells(field, corner, cell_x, cell_y, time_s=0.0):
    """All objects of the given cells with homes in the window, posed at a time [s]."""
    samples = field.sample_cells(corner, cell_x, cell_y)
    instances = field._place(corner, samples, time_s, None)
    return InstancesInView(instances, samples, np.zeros(len(samples)))
