"""A frame goes without a forecast of memory only where an earlier one covers it, with room."""

import pytest

from lod.errors import InputError
from scenes.presets.load import load_preset
from scenes.render import memory as foresight
from scenes.render.exr.header import frame_settings
from scenes.render.frame_session import FrameSession
from scenes.render.memory import _FAR_BELOW, Foresight, forecast, frame_bytes
from scenes.scene import Scene

WALK = "camera.keys=[{frame=1, position=[0, 0], height=2, target=[0, 9, 2]},"
TURNED = WALK + "{frame=2, position=[0.4, 0.4], height=2, target=[9, 0, 0]}]"
DOWN = WALK + "{frame=2, position=[0, 0], height=1.1, target=[0, 9, 0]}]"
FAR = WALK + "{frame=2, position=[0, 3], height=2, target=[0, 9, 2]}]"
LONG = WALK + "{frame=2, position=[0, 0], height=2, target=[0, 9, 2], fov=4}]"
VARIANT = "scalar_rgb"


@pytest.fixture
def asked(monkeypatch):
    """Frames that were given a forecast of their own."""
    frames = []
    monkeypatch.setattr(
        foresight, "check_frame_forecast", lambda scene, frame, *rest: frames.append(frame)
    )
    return frames


def shot(path, *settings):
    preset = load_preset("zoo", [path, 'render.size="160x90"', *settings])
    return Scene(preset)


@pytest.mark.parametrize("path", [TURNED, DOWN])
def test_a_frame_near_another_is_covered_and_needs_no_more_than_four_times(path, asked):
    scene = shot(path)
    sight = Foresight(scene, VARIANT)
    for frame in (1, 1, 2, 1, 2):
        sight.check(frame, 16 * 10**9)
    assert asked == [1, 1]
    around = forecast(scene.world, sight._around.view)
    for frame in (1, 2):
        assert forecast(scene.world, scene.view(frame)).parts <= 4 * around.parts


@pytest.mark.parametrize("path", [FAR, LONG])
def test_a_frame_from_elsewhere_or_of_finer_detail_is_foretold(path, asked):
    scene = shot(path)
    sight = Foresight(scene, VARIANT)
    for frame in (1, 1, 2):
        sight.check(frame, 16 * 10**9)
    assert asked == [1, 1, 2]


def test_near_the_limit_every_frame_is_foretold_and_no_other_work_done(asked, monkeypatch):
    scene = shot(TURNED)
    needed = frame_bytes(forecast(scene.world, scene.view(1)), scene.preset, VARIANT)
    sight, looked = Foresight(scene, VARIANT), []
    monkeypatch.setattr(sight, "_look_around", looked.append)
    for frame in (1, 2, 1, 2):
        sight.check(frame, int(needed * _FAR_BELOW / 2))
    assert asked == [1, 2, 1, 2] and len(looked) == 1


def test_what_is_too_much_is_refused_on_any_frame():
    scene = shot(FAR)
    sight = Foresight(scene, VARIANT)
    sight.check(1, 16 * 10**9)
    sight.check(1, 16 * 10**9)
    for most in (10**6, 10**8):
        with pytest.raises(InputError, match="needs about"):
            sight.check(1, most)
    sight.check(1, 0)


def test_a_session_foretells_frames_and_renders_none(tmp_path, asked):
    preset = load_preset("zoo", [FAR, 'render.size="160x90"'])
    session = FrameSession(frame_settings(preset, VARIANT))
    assert session.foretell((1, 2), tmp_path, 16 * 10**9) == {}
    assert asked == [1, 2] and list(tmp_path.iterdir()) == []
