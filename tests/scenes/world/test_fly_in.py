"""The flight to a hand (figure 5), read from the cuts of its frames."""

from functools import lru_cache

import numpy as np

from lod.pruner import prune
from scenes.figures.animal_file import human_tables
from scenes.presets.load import load_preset
from scenes.scene import Scene

FRAMES = range(1, 49)
HAND = "right hand"
FINGERS = ("index", "middle", "ring", "little", "thumb")
RIGHT_FINGERS = {f"right {finger} finger" for finger in FINGERS}


@lru_cache(maxsize=1)
def flight():
    """Names of the displayed parts of the person, frame by frame."""
    preset = load_preset("fly_in")
    scene, names = Scene(preset), human_tables().part_names
    cuts = [prune(scene.world.cast, scene.view(frame)) for frame in FRAMES]
    return [{names[row] for row in cut.parts.part.tolist()} for cut in cuts]


def test_the_flight_ends_at_the_right_hand():
    """It fills the middle of the last frame: the hand and its fingers within 15° of the axis."""
    preset = load_preset("fly_in")
    scene, names = Scene(preset), human_tables().part_names
    view = scene.view(FRAMES[-1])
    parts = prune(scene.world.cast, view).parts
    at = {names[row]: here for row, here in zip(parts.part, parts.position, strict=True)}
    for name in RIGHT_FINGERS | {HAND}:
        ray = at[name] - view.camera.eye
        cosine = ray @ view.camera.forward / np.linalg.norm(ray)
        assert cosine > np.cos(np.radians(15)), name
        assert np.linalg.norm(ray) < 1.0


def first(name):
    """The first frame that shows a part."""
    shown = [frame for frame, parts in zip(FRAMES, flight(), strict=True) if name in parts]
    assert shown, f"{name} is never displayed"
    return shown[0]


def test_the_flight_starts_far_off_and_shows_more_and_more():
    counts = [len(parts) for parts in flight()]
    assert counts[0] < 12
    assert counts[-1] > 3 * counts[0]
    assert len(set(counts)) > 8  # not all at once


def test_no_part_vanishes_as_the_camera_comes_nearer():
    for frame, before, after in zip(FRAMES, flight(), flight()[1:], strict=False):
        assert before <= after, f"frame {frame + 1} has lost {before - after}"


def test_the_hand_comes_before_its_fingers():
    assert first("person") == 1
    assert first("right forearm") <= first(HAND)
    assert 1 < first(HAND) < min(first(finger) for finger in RIGHT_FINGERS)
