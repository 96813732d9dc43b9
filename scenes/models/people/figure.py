"""Standing people: the stick figure of figs 1 and 2, down to the finger joints, in its one pose.

The origin of the person (and of its torso) is the pelvis; every other part's is the joint at its
near end. The person faces +x, both soles on z = 0. P, R and B hold for every pose (``rig_figure``).
"""

from functools import lru_cache

from scenes.models.people.people import people_at_rest
from scenes.sticks.prototype import Prototype


@lru_cache(maxsize=16)
def standing_people(seed: int, count: int) -> tuple[Prototype, ...]:
    """``count`` standing adults; the k-th depends on the seed and on k only."""
    return tuple(person.posed() for person in people_at_rest(seed, count, children=0.0))
