"""How people and animals stand on slopes: ``python -m bench.studies.slopes``.

Of every kind that walks, over planes of each slope in eight directions and at three strides: how
far any joint of a leg goes beyond its limits, and how far feet that stand sink, float and slide.
"""

import numpy as np

from bench.cli.output import table
from scenes.gait.patrol import MIN_STRIDE_FACTOR
from scenes.gait.slope_errors import ContactErrors, SlopeTrial
from scenes.models.animals.catalogue import KINDS, animal
from scenes.models.people.people import people_at_rest
from scenes.models.people.walking import walking_people
from scenes.rig.rigged_prototype import RiggedPrototype

SLOPES = (0.0, 0.05, 0.1, 0.16, 0.2, 0.3)
PACES = (MIN_STRIDE_FACTOR, (1 + MIN_STRIDE_FACTOR) / 2, 1.0)
DIRECTIONS = 8


def worst(who: RiggedPrototype, slope: float) -> ContactErrors:
    """The worst of all directions and strides, each measure by itself."""
    angles = 2 * np.pi * np.arange(DIRECTIONS if slope else 1) / DIRECTIONS
    planes = slope * np.stack((np.cos(angles), np.sin(angles)), axis=1)
    each = [
        SlopeTrial(who, plane, stride_factor).steps() for plane in planes for stride_factor in PACES
    ]
    return ContactErrors(*np.max(each, axis=0).tolist())


def _kinds() -> dict[str, RiggedPrototype]:
    """An adult, a child, and every animal that has legs."""
    people = {name: walking_people(people_at_rest(5, 1, share), 0)[0] for name, share in
              (("person", 0.0), ("child", 1.0))}  # fmt: skip
    return people | {name: animal(name) for name, kind in KINDS.items() if kind.gait.legs}


def _print() -> None:
    rows = [["kind", "slope", "beyond [°]", "sinks [mm]", "floats [mm]", "slides [mm]"]]
    for name, who in _kinds().items():
        for slope in SLOPES:
            beyond, *lengths = worst(who, slope)
            rows.append([name, f"{slope:g}", f"{beyond:.2f}", *(f"{1e3 * x:.1f}" for x in lengths)])
    print(table(rows))


if __name__ == "__main__":
    _print()
