import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lod.camera import GRID_M
from lod.errors import InputError
from scenes.presets.load import load_preset
from scenes.presets.schema import CameraKey, CameraPreset
from scenes.world.camera_path import camera_at, height_at

SIZE = (64, 36)


class Waves:
    """Rolling ground with a closed form, that repeats too seldom to matter."""

    def height(self, corner, xy):
        at = xy + GRID_M * np.array([(c + 2048) % 4096 - 2048 for c in (corner.x, corner.y)])
        return 3 * np.sin(at[:, 0] / 13) + 2 * np.cos(at[:, 1] / 7)

    def bounds(self):
        return -5.0, 5.0


GROUND = Waves()
AREA = st.floats(-60, 60)


def absolute(camera, cell=(0, 0)):
    """Where the eye is, from a cell's corner [m]."""
    corner = camera.corner.x - cell[0], camera.corner.y - cell[1]
    return camera.eye + np.array((*corner, 0)) * GRID_M


@st.composite
def flights(draw):
    """A camera with keys, the target at least 1 m in front of every key."""
    count = draw(st.integers(2, 6))
    frames = sorted(draw(st.sets(st.integers(1, 300), min_size=count, max_size=count)))
    keys = tuple(
        CameraKey(
            frame=frame,
            position=(draw(AREA), draw(AREA)),
            height=draw(st.floats(0.1, 30)),
            target=(draw(AREA) + 200, draw(AREA), draw(st.floats(0, 20))),
        )
        for frame in frames
    )
    cell = draw(st.tuples(*(st.integers(-(2**40), 2**40),) * 2))
    return CameraPreset(keys=keys, cell=cell, fov=draw(st.floats(10, 120)))


def target_of(preset, key):
    x, y, up = key.target
    return np.array((x, y, height_at(GROUND, x, y, preset.cell) + up))


@given(flights())
def test_keys_are_met(preset):
    for key in preset.keys:
        camera = camera_at(preset, SIZE, key.frame, GROUND)
        ground = height_at(GROUND, *key.position, preset.cell)
        place = *key.position, ground + key.height
        assert absolute(camera, preset.cell) == pytest.approx(place, abs=1e-9)


@given(flights())
def test_the_target_stays_in_the_centre(preset):
    for key in preset.keys:
        camera = camera_at(preset, SIZE, key.frame, GROUND)
        ray = target_of(preset, key) - absolute(camera, preset.cell)
        along = ray @ camera.forward
        assert along > 0
        assert np.linalg.norm(ray - along * camera.forward) < 1e-9
        assert abs(camera.up @ camera.forward) < 1e-12
        assert camera.up[2] >= 0  # never upside down
        assert camera.fov_x == math.radians(preset.fov)


@given(flights())
def test_before_the_first_and_after_the_last_key_the_camera_waits(preset):
    for key, beyond in ((preset.keys[0], -1), (preset.keys[-1], 1)):
        there = camera_at(preset, SIZE, key.frame, GROUND)
        for far in (1, 1000):
            waits = camera_at(preset, SIZE, key.frame + beyond * far, GROUND)
            assert waits.corner == there.corner
            assert np.array_equal(waits.eye, there.eye)
            assert np.array_equal(waits.forward, there.forward)


@given(flights())
def test_between_two_keys_nothing_overshoots(preset):
    """Monotone cubics: no coordinate leaves the range of the keys on either side."""
    for a, b in pairwise(preset.keys):
        frame = (a.frame + b.frame) // 2
        eye = absolute(camera_at(preset, SIZE, frame, GROUND), preset.cell)
        for axis in (0, 1):
            low, high = sorted((a.position[axis], b.position[axis]))
            assert low - 1e-9 <= eye[axis] <= high + 1e-9
        above = eye[2] - height_at(GROUND, eye[0], eye[1], preset.cell)
        low, high = sorted((a.height, b.height))
        assert low - 1e-6 <= above <= high + 1e-6


@settings(max_examples=30)
@given(st.floats(-360, 360), st.floats(-50, 50), st.sampled_from((10.0, 24.0, 30.0)), AREA, AREA)
def test_a_walk_is_even_and_straight(heading, speed, fps, x, y):
    preset = CameraPreset(position=(x, y), heading=heading, speed=speed, fps=fps, height=1.7)
    cameras = [camera_at(preset, SIZE, frame, GROUND) for frame in (1, 2, 3, 30)]
    places = np.array([absolute(camera) for camera in cameras])
    step = np.array((math.sin(math.radians(heading)), math.cos(math.radians(heading))))
    walked = np.array((0, 1, 2, 29))[:, None] * step * speed / fps
    assert places[:, :2] == pytest.approx(np.array((x, y)) + walked, abs=1e-9)
    heights = [height_at(GROUND, *place[:2]) + 1.7 for place in places]
    assert places[:, 2] == pytest.approx(heights, abs=1e-9)
    assert all(np.array_equal(c.forward, cameras[0].forward) for c in cameras)


@pytest.mark.parametrize(
    ("frames", "rule"),
    [
        ((1,), "2 keys or more"),
        ((5, 5), "order of their frames"),
        ((9, 3), "order of their frames"),
    ],
)
def test_keys_that_make_no_flight_are_refused(frames, rule):
    keys = ", ".join(
        f"{{frame={f}, position=[0.0, 0.0], height=1.0, target=[1.0, 0.0, 0.0]}}" for f in frames
    )
    with pytest.raises(InputError, match=rf"camera\.keys.*{rule}"):
        load_preset("fly_in", [f"camera.keys=[{keys}]"])


@given(focal=st.floats(4, 800), sensor=st.floats(4, 60))
def test_a_lens_sees_as_wide_as_its_sensor(focal, sensor):
    preset = CameraPreset(focal_length=focal, sensor_width=sensor, fov=10.0)
    tan_x, _ = camera_at(preset, SIZE, 1, GROUND).tan_half
    assert tan_x == pytest.approx(sensor / 2 / focal)


@given(roll=st.floats(-360, 360), pitch=st.floats(-80, 80), heading=st.floats(-180, 180))
def test_roll_turns_about_the_line_of_sight(roll, pitch, heading):
    level = CameraPreset(pitch=pitch, heading=heading)
    rolled = level.model_copy(update={"roll": roll})
    a, b = (camera_at(each, SIZE, 1, GROUND) for each in (level, rolled))
    assert np.array_equal(a.forward, b.forward)
    angle = math.radians(roll)
    assert b.up @ a.up == pytest.approx(math.cos(angle), abs=1e-12)
    assert b.up @ a.right == pytest.approx(math.sin(angle), abs=1e-12)
    assert np.linalg.norm(b.up) == pytest.approx(1)


def test_a_flight_zooms_and_rolls_between_its_keys():
    ends = {"position": (0.0, 0.0), "height": 2.0, "target": (0.0, 50.0, 1.0)}
    keys = (CameraKey(frame=1, **ends), CameraKey(frame=11, fov=20.0, roll=90.0, **ends))
    preset = CameraPreset(keys=keys, fov=60.0)
    cameras = [camera_at(preset, SIZE, frame, GROUND) for frame in (1, 6, 11)]
    fov = [math.degrees(each.fov_x) for each in cameras]
    assert fov[0] == pytest.approx(60) and fov[2] == pytest.approx(20)
    assert 20 < fov[1] < 60
    assert cameras[2].right[2] < -0.95  # its right side is down


def test_a_lens_opens_as_wide_as_its_focal_length_and_f_number_say():
    preset = CameraPreset(focal_length=50.0, f_stop=2.0, focus=12.0)
    lens = camera_at(preset, SIZE, 1, GROUND).lens
    assert lens.diameter_m == pytest.approx(0.025)
    assert lens.focus_m == 12.0
    assert camera_at(CameraPreset(focal_length=50.0), SIZE, 1, GROUND).lens is None


def test_a_point_is_in_focus_at_its_depth_along_the_axis():
    """30° aside of the axis the plane in focus is nearer than the point."""
    preset = CameraPreset(heading=30.0, f_stop=2.0, focus=(0.0, 20.0, 1.7))
    camera = camera_at(preset, SIZE, 1, GROUND)
    base, there = (height_at(GROUND, *xy) for xy in ((0.0, 0.0), (0.0, 20.0)))
    assert camera.forward[2] == 0 and there != base
    assert camera.lens.focus_m == pytest.approx(20 * math.cos(math.radians(30)))


def test_a_point_behind_the_camera_cannot_be_in_focus():
    preset = CameraPreset(heading=180.0, f_stop=2.0, focus=(0.0, 20.0, 1.7))
    with pytest.raises(InputError, match="before the camera"):
        camera_at(preset, SIZE, 1, GROUND)


def a_pull(**of_keys):
    """A flight of three keys past a target, with f-numbers or distances in focus at the keys."""
    keys = [
        {"frame": frame, "position": (0.0, y), "height": 2.0, "target": (0.0, 40.0, 2.0)}
        for frame, y in ((1, 0.0), (11, 10.0), (21, 20.0))
    ]
    for name, values in of_keys.items():
        for key, value in zip(keys, values, strict=True):
            key[name] = value
    return tuple(CameraKey(**key) for key in keys)


def test_a_flight_is_focused_on_its_target():
    for frame in (1, 6, 21):
        camera = camera_at(CameraPreset(keys=a_pull(), f_stop=4.0), SIZE, frame, GROUND)
        assert camera.lens.focus_m == pytest.approx(np.linalg.norm(_to_target(camera)))


def _to_target(camera):
    return np.array((0.0, 40.0, height_at(GROUND, 0.0, 40.0) + 2.0)) - absolute(camera)


def test_focus_and_f_number_are_pulled_from_key_to_key():
    keys = a_pull(focus=(40.0, 10.0, 2.5), f_stop=(2.0, 2.0, 8.0))
    at = [camera_at(CameraPreset(keys=keys), SIZE, frame, GROUND) for frame in (1, 6, 11, 21)]
    focus = [camera.lens.focus_m for camera in at]
    assert [focus[0], focus[2], focus[3]] == pytest.approx([40.0, 10.0, 2.5])
    assert focus[1] == pytest.approx(20.0)  # half of the way in logarithms
    width = [camera.lens.diameter_m for camera in at]
    assert width[0] == pytest.approx(width[2]) == pytest.approx(4 * width[3])


@pytest.mark.parametrize(
    "keys",
    [
        {"f_stop": 2.0, "focus": 0.0},
        {"f_stop": 0.0, "focus": 3.0},
        {"keys": a_pull(f_stop=(2.0, None, 2.0))},
        {"f_stop": 2.0, "keys": a_pull(focus=(2.0, None, 2.0))},
    ],
)
def test_a_lens_that_cannot_be_focused_is_refused(keys):
    with pytest.raises(ValueError):
        CameraPreset(**keys)
