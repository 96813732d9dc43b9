"""Small hand-made frames: walls, balls, a ground; and the variants that work here."""

import numpy as np
import pytest

from lod.air import CLEAR
from lod.camera import Corner, camera_from_heading
from lod.pruner import Parts, cut_from_parts
from lod.shapes import Sticks, Triangles
from scenes.frame.frame_input import DisplayedRepresentation, FrameInput, Light, Quality
from scenes.render import variants
from scenes.render.render import render_frame

GPU_VARIANT = "cuda_ad_rgb"
DRIVERS = [variants.SCALAR_VARIANT, variants.JIT_VARIANT]
if variants.works(GPU_VARIANT) is True:
    DRIVERS.append(GPU_VARIANT)


@pytest.fixture(params=DRIVERS)
def variant(request):
    """Each frame driver's variant; skips with the reason where it does not work."""
    answer = variants.works(request.param)
    if answer is not True:
        pytest.skip(f"{request.param} does not work here: {answer}")
    return request.param


def cut(objects, parts, levels):
    n, zero = len(objects), np.zeros(len(objects))
    made = Parts(
        position=np.zeros((n, 3)),
        centre=np.zeros((n, 3)),
        bound=zero,
        limit=zero,
        limit_offscreen=zero,
        level=np.asarray(levels),
        object=np.asarray(objects),
        part=np.asarray(parts),
        parent=np.full(n, -1),
        share=np.ones(n),
    )
    return cut_from_parts(made, n, n)


class Making:
    """Builders of what is visible."""

    clear = CLEAR
    light = Light(sun_azimuth_deg=200, sun_elevation_deg=40)

    @staticmethod
    def camera(size=(16, 8), heading=0.0, pitch=0.0, fov=60.0, eye=(0.0, 0.0, 2.0)):
        return camera_from_heading(Corner(0, 0), np.array(eye), heading, pitch, fov, size)

    @staticmethod
    def balls(centres, radius=0.5, albedo=0.5, name="balls", first_part=100, level=2):
        """One ball, one object, one part each."""
        n, centres = len(centres), np.asarray(centres, float)
        shape = Sticks(
            start=centres,
            end=centres,
            start_radius=np.full(n, radius),
            end_radius=np.full(n, radius),
            tint=np.zeros(n),
            tints=np.full((1, 3), albedo),
            owner=np.arange(n),
        )
        numbers = np.arange(n)
        return DisplayedRepresentation(
            name, cut(numbers, first_part + numbers, np.full(n, level)), shape
        )

    @staticmethod
    def quad(corners, albedo=0.5, name="quad"):
        """Four corners, counter-clockwise seen from outside; one object, part 7, level 3."""
        corners = np.asarray(corners, float)
        normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
        shape = Triangles(
            vertices=corners,
            normals=np.tile(normal / np.linalg.norm(normal), (4, 1)),
            colours=np.broadcast_to(albedo, (4, 3)),
            faces=np.array([[0, 1, 2], [0, 2, 3]]),
            owner=np.zeros(2),
        )
        return DisplayedRepresentation(name, cut([0], [7], [3]), shape)

    @classmethod
    def wall(cls, distance, albedo):
        """Faces a camera that looks north, wider than any narrow view."""
        y, s = float(distance), distance * 0.4
        corners = [(-s, y, -s), (s, y, -s), (s, y, s), (-s, y, s)]
        return cls.quad(corners, albedo, "wall")

    @classmethod
    def ground(cls, reach=2000.0, albedo=(0.1, 0.2, 0.05)):
        s = float(reach)
        return cls.quad([(-s, -s, 0), (s, -s, 0), (s, s, 0), (-s, s, 0)], albedo, "ground")

    @classmethod
    def frame(cls, *displayed, variant=variants.SCALAR_VARIANT, after=None):
        """The input of a frame of these, in clear air."""
        quality = cls.quality(variant, max_depth=4)
        return FrameInput(cls.camera(), displayed, CLEAR, cls.light, quality, after)

    @classmethod
    def rendered(
        cls, variant, *displayed, camera=None, air=CLEAR, light=light, after=None, **quality
    ):
        """The layers of a frame of these."""
        own = cls.quality(variant, **quality)
        return render_frame(FrameInput(camera or cls.camera(), displayed, air, light, own, after))

    @staticmethod
    def quality(variant, spp=4, seed=1, max_depth=3):
        return Quality(variant, spp, seed, max_depth)


@pytest.fixture(scope="session")
def make():
    return Making
