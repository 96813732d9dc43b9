"""Every representation keeps the rules of the suite, and the suite notices one that does not."""

from dataclasses import dataclass, replace
from functools import partial

import numpy as np
import pytest

from bench.conformance import RULES, Subject
from lod.actors.actor import Quaternion
from lod.actors.object_with_parts import ask, change
from lod.camera import Corner, camera_from_heading
from lod.errors import InputError
from scenes.actors.body import Body
from scenes.actors.performance import posed_prototype
from scenes.field.species_field import Placed, Species, SpeciesField
from scenes.figures.animal_file import animal, people_at_rest
from scenes.ground.mesh import Terrain
from scenes.models.catalogue import MODELS, model_prototypes
from scenes.models.stone import boulder_prototypes
from scenes.particles.dust import Dust
from scenes.particles.footfalls import Soil
from scenes.particles.system import KINDS, Plume
from scenes.trees.species import Weather

GROUND = Terrain(seed=4, amplitude=0.4, wavelength=16.0, hurst=0.8, reach=100.0, finest=1.0)
SWAYING = ("tree", "birch", "conifer", "shrub", "dead_tree", "sward")
LEGGED = ("figure", "rabbit", "giraffe", "ostrich", "insect")
WINDY = Weather("autumn", 6.0)


def camera(far, height, size=(90, 50)):
    """South of the plane's origin, looking north over some of what stands about it."""
    eye = np.array((0.0, -far, height))
    return camera_from_heading(Corner(0, 0), eye, -8.0, -4.0, 65.0, size)


def species(model, count, walks, weather):
    """A window of the field with about ``count`` objects, as far apart as they are large."""
    prototypes = model_prototypes(model, 1, (0.8, 1.0), walks, weather)
    reach = max(float(p.hierarchy.B[0]) for p in prototypes)
    extent = (4 + 4 * walks) * reach * count**0.5
    kind = Species(model, prototypes, count / extent**2, 2.0 * reach * walks)
    view = Subject(
        partial(SpeciesField, kind, 0, GROUND, extent), camera(1.2 * extent, 1.5 * reach)
    )
    for seed in range(1, 100):
        make = partial(SpeciesField, kind, seed, GROUND, extent)
        if len(make().roots(view.view("full"))) == count:
            return replace(view, make=make, detail=4.0 if reach > 2 else 1.5)
    raise AssertionError("no seed with so many objects")


def with_position(prototype, detail=0.3):
    reach = float(prototype.hierarchy.B[0])
    make = partial(Placed, "it", prototype, 0.0, 0.0, 70.0, GROUND)
    return Subject(make, camera(6 * reach, reach), detail)


def bowing():
    """A person whom messages made bow, as live actors are drawn."""
    who = people_at_rest(0, 1, 0.0)[0]
    actor = Body("joe", who)
    bow = Quaternion(0.0, np.sin(0.2), 0.0, np.cos(0.2))
    assert actor.receive(change("torso/abdomen", "orient", bow)).value is None
    posture = actor.receive(ask("", "posture")).value
    return with_position(posed_prototype(who, posture.eighths, posture.held))


def terrain(**changes):
    ground = {"seed": 3, "amplitude": 30.0, "wavelength": 512.0, "hurst": 0.9, "reach": 200.0}
    make = partial(Terrain, **(ground | {"finest": 1.0} | changes))
    eye = np.array((8.0, 8.0, 40.0))
    return Subject(make, camera_from_heading(Corner(3, -70), eye, 20.0, -10.0, 60.0, (90, 50)), 3.0)


def plume(kind):
    make = partial(Plume, kind, KINDS[kind], 5, 0.0, 0.0, GROUND)
    height = KINDS[kind].height
    return Subject(make, camera(2.5 * height, 0.5 * height), 0.5)


def dust():
    """What two walkers raise, one of them in view."""
    walking = species("figure", 2, True, WINDY)
    soil = Soil(GROUND.relief, "bare")
    near = camera(22.0, 1.5, (900, 500))
    return replace(walking, make=lambda: Dust(walking.make(), soil, 4.0), camera=near, detail=1.0)


SUBJECTS = {
    "dust": dust,
    **{kind: partial(plume, kind) for kind in KINDS},
    **{model: partial(species, model, 3, False, Weather("summer", 0.0)) for model in MODELS},
    **{f"walking {model}": partial(species, model, 4, True, WINDY) for model in LEGGED},
    **{f"swaying {model}": partial(species, model, 2, False, WINDY) for model in SWAYING},
    "placed boulder": lambda: with_position(boulder_prototypes(0, 1)[0]),
    "placed windmill": lambda: with_position(animal("windmill")),
    "actor": bowing,
    "terrain": terrain,
    "flat terrain": partial(terrain, amplitude=0.0),
    "rough terrain": partial(terrain, hurst=0.4, amplitude=8.0),
}


QUICK = ("rabbit", "walking ostrich", "swaying tree", "actor", "terrain", "flames")
each_subject = [
    pytest.param(name, marks=() if name in QUICK else pytest.mark.slow) for name in SUBJECTS
]


def broken_rules(subject):
    return [(name, found) for name, rule in RULES.items() for found in rule(subject)]


@pytest.mark.parametrize("name", each_subject)
def test_it_keeps_every_rule(name):
    assert broken_rules(SUBJECTS[name]()) == []


@dataclass(frozen=True)
class Wrapped:
    """A good representation of which one answer is wrong."""

    it: object
    change: object

    name = "wrapped"

    def roots(self, view):
        return self.change("roots", self.it.roots(view), view)

    def parts_of(self, parts, view):
        return self.change("parts_of", self.it.parts_of(parts, view), view)

    def appearance(self, parts, looks):
        return self.change("appearance", self.it.appearance(parts, looks), None)

    def later(self, parts, view, time_s):
        return self.change("later", self.it.later(parts, view, time_s), view)


CALLS = []


def wrong(where, alter):
    return lambda asked, answer, view: alter(answer, view) if asked == where else answer


def noise(_):
    CALLS.append(1)
    return len(CALLS) * 1e-7


FAULTS = {
    "bound": ("inside_its_bound", wrong("roots", lambda p, _: replace(p, bound=p.bound * 0.5))),
    "looks": (
        "inside_its_bound",
        wrong("appearance", lambda s, _: replace(s, end_radius=s.end_radius + 5.0)),
    ),
    "limit": ("limits_never_grow", wrong("roots", lambda p, _: replace(p, limit=p.limit * 0.5))),
    "levels": ("limits_never_grow", wrong("roots", lambda p, _: replace(p, level=p.level + 9))),
    "roots": (
        "roots_leave_nothing_out",
        wrong("roots", lambda p, v: p if v.look_around else p.take(np.arange(len(p)) < 1)),
    ),
    "chance": (
        "same_seed_same_bytes",
        wrong("roots", lambda p, v: replace(p, bound=p.bound + noise(v))),
    ),
    "nan": (
        "arrays_only",
        wrong("appearance", lambda s, _: replace(s, start=s.start * np.nan)),
    ),
    "shares": ("arrays_only", wrong("parts_of", lambda p, _: replace(p, share=p.share * 0.9))),
    "owners": (
        "any_request_is_answered",
        wrong("parts_of", lambda p, _: replace(p, parent=np.zeros_like(p.parent))),
    ),
    "later": (
        "later_looks_alike",
        wrong("later", lambda p, _: replace(p, part=np.zeros_like(p.part))),
    ),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_the_suite_notices(fault):
    rule, change_ = FAULTS[fault]
    good = species("ostrich", 3, True, Weather("summer", 0.0))
    make = partial(Wrapped, good.make(), change_)
    assert list(RULES[rule](replace(good, make=make)))


def test_the_suite_notices_a_walk_of_its_own_making():
    """A compiled walk that gives another cut than the parts' own tests."""
    good = species("ostrich", 3, False, Weather("summer", 0.0))

    class Short(SpeciesField):
        def cut(self, view):
            return super().cut(replace(view, detail=1.1 * view.detail))

    field = good.make()
    make = partial(Short, field.species, field.seed, field.ground, field.extent)
    assert list(RULES["agrees_with_brute_force"](replace(good, make=make)))


def test_what_cannot_be_held_whole_is_refused(monkeypatch):
    monkeypatch.setattr("bench.conformance.MOST_PARTS", 100)
    with pytest.raises(InputError, match="at most 100 parts"):
        broken_rules(SUBJECTS["flat terrain"]())
