"""An animal is one TOML file: what it may say, and how each mistake is answered in one line."""

import numpy as np
import pytest

from lod.errors import InputError
from scenes.figures.anatomy import Build, build_prototype
from scenes.figures.animal_file import AnimalFile, animal, animal_tables, load_animal
from scenes.rig.rig import to_euler
from tests.scenes.figures.contact_errors import lowest_heights, sample_cycle
from tests.scenes.figures.motion_phase import motion_at


@pytest.mark.parametrize("name", ["giraffe", "ostrich", "insect"])
def test_walkers_always_stand_on_something(name):
    it = animal(name)
    seen = sample_cycle(it)
    assert lowest_heights(it, seen).max() < 0.01 * it.rig.frames()[0][0, 2] + 1e-3


def test_giraffes_put_down_their_feet_in_lateral_sequence():
    hind, fore = animal_tables("giraffe").gait.legs
    order = [hind.strike, fore.strike, hind.strike + hind.apart, fore.strike + fore.apart]
    assert order == sorted(order)
    assert np.allclose(np.diff(order), 0.25, atol=0.05)


def test_an_insect_walks_on_alternating_tripods():
    fore, mid, hind = animal_tables("insect").gait.legs
    assert fore.strike == hind.strike
    assert (mid.strike - fore.strike) % 1 == fore.apart == 0.5


def test_sails_go_round_once_a_cycle():
    it = animal("windmill")
    hub = it.rig.row("hub")
    turned = [to_euler(motion_at(it.motion, k / 60)[0][hub])[0] for k in range(61)]
    assert np.allclose(np.diff(np.unwrap(turned, period=360)), 6.0, atol=1e-6)
    assert it.motion.speed == 0


BIRD = """
height = 0.4
shift = [[-0.1, -0.1, -0.1], [0.1, 0.1, 0.1]]

[materials]
feather = [0.1, 0.1, 0.1]

[joints]
trunk = { at = [0, 0, 2] }
neck = { parent = "trunk", at = [1, 0, 0], rest = [0, 30, 0], hinge = [-10, 60] }

[side_joints]
hip = { parent = "trunk", at = [0, 0.5, 0], free = [10, 40, 10] }
knee = { parent = "hip", at = [0, 0, -1], rest = [0, 10, 0], hinge = [0, 90] }
ankle = { parent = "knee", at = [0, 0, -1], free = [40, 60, 40] }

[parts.bird]
level = 0
joint = "trunk"
body = [{ start = [-1, 0, 0], end = [1, 0, 0], radii = [0.4, 0.3], material = "feather" }]

[parts.head]
whole = "bird"
level = 1
joint = "neck"
body = [
    { start = [1, 0, 0], end = [2, 0, 1], radii = [0.2, 0.1], material = "feather", around = 4 },
]

[side_parts.leg]
whole = "bird"
level = 1
joint = "hip"
body = [
    { joint = "ankle", start = [0, 0, 0], end = [1, 0, 0], radii = [0.1, 0.1], material = "mean" },
]

[gait]
froude = 0.1

[[gait.legs]]
hip = "hip"
knee = "knee"
ankle = "ankle"
"""


def tables(tmp_path, text):
    path = tmp_path / "bird.toml"
    path.write_text(text, encoding="utf-8")
    return load_animal(path, AnimalFile)


def built(tmp_path):
    it = tables(tmp_path, BIRD.replace('"mean"', '"feather"'))
    return build_prototype("bird", it, Build(it.height, it.materials))


def test_a_file_becomes_anatomy_build_and_gait(tmp_path):
    it = tables(tmp_path, BIRD)
    assert it.part_names == ("bird", "head", "left leg", "right leg")
    rig = built(tmp_path).rig
    assert rig.name[:2] == ("trunk", "neck") and rig.name[2] == "left hip"
    limits = {
        name: (low, high) for name, low, high in zip(rig.name, rig.low, rig.high, strict=True)
    }
    assert np.array_equal(limits["neck"], ((0, -10, 0), (0, 60, 0)))
    assert np.array_equal(limits["left hip"], ((-10, -40, -10), (10, 40, 10)))
    assert not np.any(limits["trunk"])  # it does not turn
    rest = {name: joint.rest for name, joint in (it.joints | it.side_joints).items()}
    assert {name: each for name, each in rest.items() if any(each)} == {
        "neck": (0, 30, 0),
        "knee": (0, 10, 0),
    }
    (rod,) = it.side_parts["leg"].body
    assert (rod.joint, rod.start, rod.end, rod.material) == ("ankle", (0, 0, 0), (1, 0, 0), "mean")
    assert (it.gait.froude, it.gait.duty) == (0.1, 0.62)
    assert it.gait.legs[0].apart == 0.5


@pytest.mark.parametrize(
    ("old", "new", "where"),
    [
        ("height = 0.4", "height = 0", "bird.toml: height"),
        ("height = 0.4", "height = ", "bird.toml"),
        ("hinge = [-10, 60]", "hinge = [-10, 60], free = [1, 1, 1]", "bird.toml: joints.neck"),
        ("radii = [0.4, 0.3]", "radii = [0.4, 0]", "bird.toml: parts.bird.body[0].radii[1]"),
        ('parent = "trunk", at = [1', 'parent = "knee", at = [1', "bird.toml: joints.neck.parent"),
        (
            'whole = "bird"\nlevel = 1\njoint = "neck"',
            'level = 1\njoint = "neck"',
            "parts.head.whole",
        ),
        ('knee = "knee"', 'knee = "neck"', "bird.toml: gait.legs[0].knee"),
    ],
)
def test_a_mistake_is_answered_with_its_key(tmp_path, old, new, where):
    assert old in BIRD
    with pytest.raises(InputError) as caught:
        tables(tmp_path, BIRD.replace(old, new, 1))
    assert where in str(caught.value)
    assert "\n" not in str(caught.value)
