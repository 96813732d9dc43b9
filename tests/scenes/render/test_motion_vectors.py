"""Motion vectors: rigid motion exactly, cameras by their formulas, walkers by their joints."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lod.camera import Corner, camera_from_heading
from lod.pruner import blend_weights
from scenes.frame.frame_input import FrameInput
from scenes.frame.layers import SKY_Z
from scenes.presets.load import load_preset
from scenes.render import variants
from scenes.render.build import build_scene
from scenes.render.description import describe_frame
from scenes.render.haze import make_haze
from scenes.render.light import emitters
from scenes.render.render import render_frame
from scenes.render.samples import carry_with_stick, next_positions, project
from scenes.render.scalar_passes import render_passes
from scenes.rig.pose import pose_points
from scenes.rig.rig import rotate_vectors, shortest_arc
from scenes.scene import Scene

SIZE = (48, 27)
vectors = st.tuples(*[st.floats(-1, 1)] * 3).map(np.array)


@given(axis=vectors, to=vectors, shift=vectors, offset=vectors, along=st.floats(0, 1))
def test_a_stick_that_turns_and_goes_takes_its_points_along(axis, to, shift, offset, along):
    """Turned by the shortest way between two axes, so that nothing turns about the axis itself."""
    axis, to = (v / max(np.linalg.norm(v), 1e-9) for v in (axis, to))
    if min(np.linalg.norm(axis), np.linalg.norm(to), axis @ to) < 0.5:
        return
    start = np.array([3.0, -2.0, 1.0])
    offset = offset - (offset @ axis) * axis
    turns, point = shortest_arc(axis[None], to[None]), start + along * axis + offset
    moves = np.stack((shift, shift + to - axis))[None]
    expected = start + shift + rotate_vectors(turns, (point - start)[None])
    moved = carry_with_stick(point[None], start[None], start[None] + axis, moves)
    assert np.allclose(moved, expected, atol=1e-12)


def test_a_point_of_a_ball_goes_where_the_ball_goes():
    ball, shift = np.array([[1.0, 2.0, 3.0]]), np.array([[0.1, 0.2, -0.3]])
    moves = np.stack((shift, shift), axis=1)
    for length in (0.0, 1e-9):
        moved = carry_with_stick(ball + 0.5, ball, ball + np.array([0, 0, length]), moves)
        assert np.allclose(moved, ball + 0.5 + shift, atol=1e-9)


def camera(heading=0.0, eye=(0.0, 0.0, 2.0), cell_x=0):
    return camera_from_heading(Corner(cell_x, 0), np.array(eye), heading, 0.0, 60.0, SIZE)


def motion(make, variant, visible, before, after, spp=4):
    quality = make.quality(variant, spp)
    return render_frame(FrameInput(before, tuple(visible), make.clear, make.light, quality, after))


def places(width, height):
    """Pixel centres, x right and y up from the middle, (h, w, 2) [px]."""
    x, y = np.arange(width) + 0.5 - width / 2, height / 2 - np.arange(height) - 0.5
    return np.stack(np.meshgrid(x, y), axis=-1)


def test_a_pan_moves_the_sky_by_the_formula(make, variant):
    """x' = f·tan(atan(x/f) − pan) and y' = y·cos(atan(x/f))/cos(atan(x/f) − pan)."""
    pan_deg = 1.5
    layers = motion(make, variant, [], camera(), camera(pan_deg))
    focal = SIZE[0] / 2 / np.tan(np.radians(30))
    x, y = np.moveaxis(places(*SIZE), -1, 0)
    aside = np.arctan(x / focal)
    turn = aside - np.radians(pan_deg)
    assert (layers.Z == SKY_Z).all()
    assert np.allclose(layers.motion[..., 0], focal * np.tan(turn) - x, atol=1e-4)
    assert np.allclose(layers.motion[..., 1], y * np.cos(aside) / np.cos(turn) - y, atol=1e-4)


def test_a_dolly_towards_a_wall_spreads_it_from_the_middle(make, variant):
    """Motion is x·s/(D − s), x where the sample is: within half a pixel of the centre, and
    in the mean there."""
    wall, distance, step = make.wall(10, 0.5), 10.0, 1.0
    layers = motion(make, variant, [wall], camera(eye=(0, 0, 0)), camera(eye=(0, step, 0)))
    hit = layers.Z < SKY_Z
    growth = step / (distance - step)
    sample = layers.motion[hit] / growth - places(*SIZE)[hit]
    assert hit.sum() > 200
    assert np.abs(sample).max() < 0.5 + 1e-3
    assert np.abs(sample.mean(axis=0)).max() < 0.3


def test_a_step_into_the_next_square_of_the_grid_is_a_step(make, variant):
    """The next camera's coordinates begin at another corner; the motion is the same."""
    visible = [make.wall(10, 0.5)]
    same = camera(eye=(17.0, 0.0, 0.0))
    other = camera(eye=(1.0, 0.0, 0.0), cell_x=1)
    a, b = (motion(make, variant, visible, camera(), after).motion for after in (same, other))
    assert np.array_equal(a, b) and np.abs(a).max() > 1


def test_what_is_behind_the_next_camera_has_no_motion(make, variant):
    layers = motion(make, variant, [make.wall(5, 0.5)], camera(), camera(eye=(0, 9, 2)))
    assert (layers.motion[layers.Z < SKY_Z] == 0).all()


def test_a_ball_that_flies_takes_its_pixels_along(make, variant):
    balls = make.balls([(-1.0, 10.0, 2.0), (1.5, 8.0, 2.0)])
    shift = np.array([[0.5, 0.0, 0.25], [0.0, 0.0, 0.0]])
    shape = balls.shape
    later = replace(shape, start=shape.start + shift, end=shape.end + shift)
    layers = motion(make, variant, [replace(balls, later=later)], camera(), camera())
    focal = SIZE[0] / 2 / np.tan(np.radians(30))
    first, second = (layers.object == number for number in (1, 2))
    assert first.sum() > 5 and second.sum() > 5
    assert (layers.motion[second] == 0).all()
    nearest, farthest = focal * 0.5 / 9.5, focal * 0.5 / 10.5
    assert (layers.motion[first][:, 0] <= nearest).all()
    assert (layers.motion[first][:, 0] >= farthest).all()
    assert np.allclose(layers.motion[first][:, 1], layers.motion[first][:, 0] / 2, atol=1e-4)


WALKER = """
seed = 3
[camera]
position = [0.5, -4.0]
height = 1.3
fov = 40.0
speed = 1.0
[terrain]
amplitude = 1.0
reach = 200
[placed.walker]
model = "figure"
position = [0.0, 0.0]
heading = 60.0
walks = true
[output]
motion = true
[render]
size = "160x120"
spp = 4
variant = "scalar_rgb"
"""


@pytest.fixture(scope="module")
def walker(tmp_path_factory):
    path = tmp_path_factory.mktemp("preset") / "walker.toml"
    path.write_text(WALKER)
    preset = load_preset(str(path))
    return Scene(preset)


def sampled(scene, frame):
    """What is made of a frame, its built scene, and what its samples met."""
    variants.use("scalar_rgb")
    made = scene.input(frame, "scalar_rgb")
    described = describe_frame(made)
    haze = make_haze(described["light"], made.air)
    built = build_scene(described, emitters(described["light"]))
    samples = render_passes(built, haze, made.quality, frame, lambda taken: None)
    hit = samples.hit
    ids = built.hit_ids(hit[..., 4], hit[..., 5]) * (hit[..., :1] > 0)
    return made, built, hit, ids


@pytest.mark.parametrize(("frame", "error_px"), [(1, 0.05), (9, 0.15), (17, 0.25)])
def test_a_walker_takes_every_point_along_with_its_joint(walker, frame, error_px):
    """Points of the axes to 0.01 px; those of the surface to what its turning about the axis,
    which no round stick shows, moves them."""
    made, built, hit, ids = sampled(walker, frame)
    placed = walker.world.placed[0]
    cut = next(v.cut for v in made.displayed if v.name == "walker")
    joint = joint_of_parts(placed, cut, blend_weights(cut, walker.view(frame)))
    met = np.isin(ids[..., 1], list(joint)) & (ids[..., 0] == ids[..., 0].max())
    joints = np.array([joint[part] for part in ids[..., 1][met].tolist()])
    hits, corner = hit[met], made.camera.corner
    onto = np.concatenate((hits[:, :6], nearest_of_axis(built, hits)), axis=1)
    times = [walker.view(frame + k).time_s for k in (0, 1)]
    instances, rows = [placed._place(corner, t) for t in times], np.zeros(len(joints), np.int64)
    (o0, axes0), (o1, axes1) = (
        joint_frames(placed.prototypes.pose_tables, b, rows, joints) for b in instances
    )
    assert met.sum() > 1000
    for points, allowed in ((onto, 0.01), (hits, error_px)):
        local = np.einsum("nai,ni->na", axes0, points[:, 6:9] - o0)
        exact = o1 + np.einsum("nai,na->ni", axes1, local)
        after = built.description["after"]
        right, found = (
            project(after, p - after["eye"]) for p in (exact, next_positions(built, points))
        )
        assert np.abs(right - found).max() < allowed
        assert np.linalg.norm(exact - points[:, 6:9], axis=1).max() > 0.005


def joint_frames(pose_tables, instances, rows, joints):
    """Origin (n, 3) and the three axes (n, 3, 3) of joints."""
    all_joints = np.arange(int(joints.max()) + 1)
    origin, *ends = (
        pose_points(
            pose_tables, instances, rows, joints, np.tile(place, (len(all_joints), 1)), all_joints
        )
        for place in np.vstack((np.zeros(3), np.eye(3)))
    )
    return origin, np.stack([end - origin for end in ends], axis=1)


def nearest_of_axis(built, hits):
    """The nearest point to each hit on the axis of its stick, (n, 3)."""
    nearest = np.empty((len(hits), 3))
    for row, (shape, primitive) in enumerate(hits[:, 4:6].astype(int)):
        sticks = built.description["shapes"][built.names[shape]]
        first = int(sticks["segment_indices"][primitive])
        start, end = sticks["control_points"][first : first + 2, :3].astype(float)
        along = (hits[row, 6:9] - start) @ (end - start) / ((end - start) @ (end - start))
        nearest[row] = start + np.clip(along, 0, 1) * (end - start)
    return nearest


def joint_of_parts(placed, cut, weights):
    """The joint that each displayed part rides on, for those of which all sticks ride on one."""
    part_tables, found = placed.prototypes.part_tables, {}
    owner, stick, _, _ = part_tables.sticks_of(cut.parts.part, weights)
    for row, part in enumerate(cut.parts.part.tolist()):
        mine = stick[owner == row]
        joints = {
            *part_tables.sticks.start_joint[mine].tolist(),
            *part_tables.sticks.end_joint[mine].tolist(),
        }
        if len(joints) == 1 and min(joints) >= 0:
            found[part] = joints.pop()
    return found
