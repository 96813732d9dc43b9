"""Samples of a frame: camera rays, sums over pixels, motion vectors, and the layers of all that.

Counts of samples are exact, in groups that keep their strata. In a JIT variant the samples of each
pixel stand side by side, and sums over them are made in a fixed order: a film that many threads
add to has other last bits every time. The renderer has no camera that sees all round:
``PanoramaSensor`` is one, equirectangular.

Motion vectors: how far what a pixel shows is from there in the next frame [px].

The point that the pixel's sample met is carried along with its stick: both ends of the axis go
where the next frame has them, the point of the axis nearest to the hit between them, and what
stands off the axis turns as the axis does. Turns of a stick about its own axis are not seen: it is
round. What is met on a mesh that moves goes with the three corners of its triangle. Both points are
then projected, each by its frame's camera. What owns no moving stick
(terrain, trees) moves by the camera alone, the sky by its turn alone.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from scenes.frame.frame_input import Quality, Window
from scenes.frame.layers import SKY_Z, Coverage, Layers, add_coverage
from scenes.render.build import GUIDES, BuiltScene, load_plugin
from scenes.render.description import NEAR_M, Description
from scenes.render.light import variant_bands
from scenes.rig.rig import rotate_vectors, shortest_arc


def motion_vectors(hit: np.ndarray, built: BuiltScene, window: Window) -> np.ndarray:
    """Compute the motion of every pixel to the next frame, x right and y up, (h, w, 2) [px].

    hit: (h, w, 9) as in Samples, of a window of the picture. 0 where the point is behind the next
    camera.
    """
    camera, after = built.description["camera"], built.description["after"]
    met = hit[..., 0] > 0
    rows = pixel_directions(camera, 1, (window.top, window.bottom)).astype(np.float64)
    ahead = rows[:, window.left : window.right][~met]
    before, now = np.empty((2, *hit.shape[:2], 2))
    before[met] = project(camera, hit[met][:, 6:9] - camera["eye"])
    now[met] = project(after, next_positions(built, hit[met]) - after["eye"])
    before[~met], now[~met] = project(camera, ahead), project(after, ahead)
    moved = np.nan_to_num(now - before, nan=0.0)
    if camera["panorama"]:  # the shorter way round
        width = camera["size"][0]
        moved[..., 0] -= width * np.round(moved[..., 0] / width)
    return moved


def project(camera: Description, offset: np.ndarray) -> np.ndarray:
    """Project points into the picture, from their offsets to the eye (n, 3) [m].

    Gives x right and y up from the picture's middle, (n, 2) [px]; NaN behind the near plane.
    """
    depth = offset @ camera["forward"]
    right = np.cross(camera["forward"], camera["up"])
    if camera["panorama"]:
        aside, above = offset @ right, offset @ camera["up"]
        turn, rise = np.arctan2(aside, depth), np.arctan2(above, np.hypot(aside, depth))
        per_turn = np.array(camera["size"]) / (2 * math.pi, math.pi)
        return np.stack((turn, rise), axis=1) * per_turn
    aside = np.stack((offset @ right, offset @ camera["up"]), axis=1)
    scale = camera["size"][0] / (2 * math.tan(math.radians(camera["fov_x_deg"]) / 2))
    return scale * aside / np.where(depth > NEAR_M, depth, np.nan)[:, None]


def next_positions(built: BuiltScene, hit: np.ndarray) -> np.ndarray:
    """Find the points of hits (n, 9) in the next frame, in this one's coordinates, (n, 3)."""
    point = hit[:, 6:9].astype(np.float64)
    shape, primitive = hit[:, 4].astype(int), hit[:, 5].astype(int)
    for name, moves in built.description["moves"].items():
        rows = np.flatnonzero(shape == built.names.index(name))
        sticks = built.description["shapes"][name]
        if sticks["type"] == "mesh":
            corners = sticks["faces"][primitive[rows]].astype(int)
            places = sticks["vertices"][corners].astype(float)
            point[rows] = carry_with_triangle(point[rows], places, moves[corners].astype(float))
            continue
        first = sticks["segment_indices"][primitive[rows]].astype(int)
        start, end = (sticks["control_points"][first + k][:, :3].astype(float) for k in (0, 1))
        point[rows] = carry_with_stick(
            point[rows], start, end, moves[primitive[rows]].astype(float)
        )
    return point


def carry_with_triangle(point: np.ndarray, corners: np.ndarray, moves: np.ndarray) -> np.ndarray:
    """Carry points (n, 3) on triangles (n, 3, 3) along, whose corners move by ``moves`` (n, 3, 3).

    By barycentric coordinates (Ericson, "Real-Time Collision Detection", 2005, §3.4).
    """
    a, b, c = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0], point - corners[:, 0]
    aa, ab, bb = (np.sum(x * y, axis=1) for x, y in ((a, a), (a, b), (b, b)))
    ca, cb = np.sum(c * a, axis=1), np.sum(c * b, axis=1)
    scale = np.maximum(aa * bb - ab * ab, 1e-300)
    v, w = (bb * ca - ab * cb) / scale, (aa * cb - ab * ca) / scale
    shares = np.clip(np.stack((1 - v - w, v, w), axis=1), 0, 1)
    return point + np.einsum("nk,nkx->nx", shares, moves)


def carry_with_stick(
    point: np.ndarray, start: np.ndarray, end: np.ndarray, moves: np.ndarray
) -> np.ndarray:
    """Carry points (n, 3) along with sticks whose ends (n, 3) move by ``moves`` (n, 2, 3).

    A stick without length, or one that turns by more than 90° a frame, is not turned.
    """
    axis, moved = end - start, end + moves[:, 1] - start - moves[:, 0]
    squared = np.maximum(np.sum(axis**2, axis=1), 1e-300)
    along = np.clip(np.sum((point - start) * axis, axis=1) / squared, 0, 1)[:, None]
    offset = point - start - along * axis
    has_axis = ((axis * moved).sum(axis=1, keepdims=True) > 0) & (squared[:, None] > 1e-20)
    turns = shortest_arc(np.where(has_axis, axis, 1.0), np.where(has_axis, moved, 1.0))
    return start + moves[:, 0] + along * moved + rotate_vectors(turns, offset)


class PanoramaSensor:
    """Rays of a panorama, by the calls that drivers make of the renderer's sensors."""

    def __init__(self, camera: Description) -> None:
        self._camera = camera

    def needs_aperture_sample(self) -> bool:
        """Tell that rays start in one point."""
        return False

    def sample_ray_differential(
        self, time: Any, wavelength: Any, film: Any, aperture: Any
    ) -> tuple[Any, float]:
        """Make rays through points of the film, from (0, 0) in the upper left to (1, 1)."""
        eye, forward, up = (self._camera[name] for name in ("eye", "forward", "up"))
        axes = [_opaque(axis) for axis in (np.cross(forward, up), forward, up)]
        turn, rise = (film.x - 0.5) * (2 * math.pi), (0.5 - film.y) * math.pi
        (sine, cosine), (high, level) = dr.sincos(turn), dr.sincos(rise)
        ahead = axes[0] * (level * sine) + axes[1] * (level * cosine)
        direction = dr.normalize(ahead + axes[2] * high)
        near, far = self._camera["clip"]
        start = mi.Point3f(_opaque(eye)) + direction * near
        ray = mi.Ray3f(start, direction, time)
        ray.maxt = far - near
        return mi.RayDifferential3f(ray), 1.0


def _opaque(values: np.ndarray) -> Any:
    """Make a vector an input of the kernel, which is so not compiled anew for another one."""
    return mi.Vector3f([dr.opaque(mi.Float, float(value)) for value in values])


def sensor(
    camera: Description,
    side: int = 1,
    rows: tuple[int, int] | None = None,
    spp: int = 1,
    medium: Any = None,
    spectrum: bool = False,
) -> Any:
    """Make the camera with a film of ``side`` by ``side`` pixels to each pixel, of these ``rows``.

    ``rows`` are the first and one past the last, from the top; None: all. ``medium`` is what the
    eye is in. With ``spectrum`` the film has a channel for each band of a spectral variant. Rays
    start all over the opening of the lens where the camera has one (``pinhole`` takes it away).
    """
    if camera["panorama"]:
        return PanoramaSensor(camera)
    width, height = (side * pixels for pixels in camera["size"])
    top, bottom = rows or (0, height)
    eye, forward, up = (camera[name].tolist() for name in ("eye", "forward", "up"))
    target = [e + f for e, f in zip(eye, forward, strict=True)]
    lens: Description = {"type": "perspective"}
    if opening := camera["lens"]:
        radius = opening.diameter_m / 2
        lens = {"type": "thinlens", "aperture_radius": radius, "focus_distance": opening.focus_m}
    return load_plugin(
        {
            **lens,
            "fov": camera["fov_x_deg"],
            "fov_axis": "x",
            "near_clip": camera["clip"][0],
            "far_clip": camera["clip"][1],
            "to_world": mi.ScalarTransform4f().look_at(eye, target, up),
            "film": {
                "width": width,
                "height": height,
                "crop_offset_y": top,
                "crop_height": bottom - top,
                "rfilter": {"type": "box"},  # the only filter with the same bytes every time
                "component_format": "float32",
                **(_responses() if spectrum else {"type": "hdrfilm", "pixel_format": "rgb"}),
            },
            "sampler": {"type": "multijitter", "sample_count": spp},
            **({"medium": medium} if medium else {}),
        }
    )


def pinhole(camera: Description) -> Description:
    """Describe the same camera with everything sharp: rays go through the centre of its lens."""
    return {**camera, "lens": None}


def _responses() -> Description:
    """A film that holds the integral of radiance over each band; it sorts channels by name."""
    made = variant_bands()
    edges = [(nm - made.width / 2, nm + made.width / 2) for nm in made.wavelengths.tolist()]
    flat = {"type": "regular", "values": "1,1"}
    responses = {
        f"band{number:02d}": {**flat, "wavelength_min": low, "wavelength_max": high}
        for number, (low, high) in enumerate(edges)
    }
    return {"type": "specfilm", **responses}


@lru_cache(maxsize=64)
def sample_groups(spp: int) -> tuple[int, ...]:
    """Split ``spp`` into counts that the multijitter sampler takes as they are: 7 → (6, 1).

    It lays samples out in isqrt(n) rows, and would round any other count up.
    """
    if spp == 0:
        return ()
    count = next(n for n in range(spp, 0, -1) if n % math.isqrt(n) == 0)
    return (count, *sample_groups(spp - count))


@lru_cache(maxsize=64)
def square_sides(spp: int) -> tuple[int, ...]:
    """Split ``spp`` into few squares and give their sides, largest first: 8 → (2, 2), 16 → (4,)."""
    if spp > 1024:
        side = math.isqrt(spp)
        return (side, *square_sides(spp - side**2))
    best: list[tuple[int, ...]] = [()]
    for n in range(1, spp + 1):
        options = ((*best[n - side**2], side) for side in range(1, math.isqrt(n) + 1))
        best.append(min(options, key=lambda sides: (len(sides), max(sides))))
    return tuple(sorted(best[spp], reverse=True))


def sample_rays(
    camera: Any, size: tuple[int, int], pixels: slice, quality: Quality
) -> tuple[Any, Any]:
    """Make sampler and rays: ``quality.spp`` of each pixel of a run, numbered row by row.

    Of Mitsuba's samplers that were tried none has less noise for the time than multijitter.
    """
    (width, height), spp = size, quality.spp
    count = (pixels.stop - pixels.start) * spp
    sampler = load_plugin({"type": "multijitter", "sample_count": spp})
    sampler.set_samples_per_wavefront(spp)
    sampler.seed(quality.seed, count)
    index = dr.arange(mi.UInt32, count) // dr.opaque(mi.UInt32, spp)
    index += dr.opaque(mi.UInt32, pixels.start)
    corner = mi.Vector2f(mi.Float(index % width), mi.Float(index // width))
    film = (corner + sampler.next_2d()) / mi.ScalarVector2f(width, height)
    on_lens = sampler.next_2d() if camera.needs_aperture_sample() else mi.Point2f(0.5)
    ray, _ = camera.sample_ray_differential(0.0, 0.0, film, on_lens)
    return sampler, ray


def pixel_sums(colour: Any, spp: int) -> np.ndarray:
    """Sum the samples of each pixel of a run in each colour, (n, 3)."""
    return np.stack([np.array(dr.block_sum(channel, spp)) for channel in colour], axis=-1)


def pixel_directions(camera: dict[str, Any], side: int, rows: tuple[int, int]) -> np.ndarray:
    """Unit directions through the centres of a band of film pixels, (rows, columns, 3) float32."""
    width, height = camera["size"]
    x = (np.arange(width * side) + 0.5) / (width * side) * 2 - 1
    y = 1 - (np.arange(rows[0] * side, rows[1] * side) + 0.5) / (height * side) * 2
    forward, up = camera["forward"], camera["up"]
    right = np.cross(forward, up)
    if camera["panorama"]:
        turn, rise = math.pi * x, math.pi / 2 * y
        level = np.sin(turn)[:, None] * right + np.cos(turn)[:, None] * forward
        return (np.cos(rise)[:, None, None] * level + np.sin(rise)[:, None, None] * up).astype(
            np.float32
        )
    tan_x = math.tan(math.radians(camera["fov_x_deg"]) / 2)
    tan_y = tan_x * height / width
    x, y = x * tan_x, y * tan_y
    across, down = forward + x[:, None] * right, y[:, None] * up
    directions = across.astype(np.float32)[None] + down.astype(np.float32)[:, None]
    directions /= np.sqrt(np.sum(directions**2, axis=2, keepdims=True))
    return directions


@dataclass(eq=False)
class Samples:
    """Sums over the samples of a window of a frame, of which rgb and albedo end as means.

    window     (h, w) pixels of a picture of ``width``, by whose numbers runs of pixels come
    hit        (h, w, 9) distance, normal, shape and primitive number, and position where motion is
               asked for, of one sample of each pixel
    replaced   samples that were not finite and count as black
    counts     of samples by pixel and object, where they are asked for
    """

    window: Window
    width: int
    rgb: np.ndarray
    albedo: np.ndarray
    hit: np.ndarray
    replaced: int = 0
    counts: list[Coverage] = field(default_factory=list)

    @staticmethod
    def none_of(built: BuiltScene, quality: Quality) -> "Samples":
        """Return the sums of a frame's window of which no sample is taken yet."""
        size = built.description["camera"]["size"]
        window = quality.window_of(size)
        columns, rows = window.size
        rgb, albedo = np.zeros((2, rows, columns, 3))
        hit = np.zeros((rows, columns, 9), np.float32)  # as the renderer gives it
        return Samples(window, size[0], rgb, albedo, hit)

    def runs(self, height: int, step: int) -> Iterator[tuple[slice, int]]:
        """Yield runs of ``step`` pixels, and how many of each are in the window, if any are."""
        for first in range(0, self.width * height, step):
            pixels = slice(first, min(first + step, self.width * height))
            if taken := int(np.count_nonzero(self.window.share(pixels, self.width)[0])):
                yield pixels, taken

    def add(self, layer: str, pixels: slice, values: np.ndarray) -> None:
        """Add values (n, 3) of a run of the picture's pixels to ``rgb`` or ``albedo``."""
        inside, own = self.window.share(pixels, self.width)
        sums = getattr(self, layer).reshape(-1, 3)[own]
        sums += values.reshape(-1, 3)[inside]

    def keep(self, pixels: slice, guides: np.ndarray) -> None:
        """Keep the guides of one sample of each pixel of a run, with channels as build.GUIDES."""
        inside, own = self.window.share(pixels, self.width)
        columns = [0, 1, 2, 3, 7, 8, *range(9, guides.shape[-1])]
        flat = guides.reshape(-1, guides.shape[-1])[inside]
        self.hit.reshape(-1, 9)[own, : len(columns)] = flat[:, columns]

    def count_objects(self, built: BuiltScene, pixels: slice, guides: np.ndarray) -> None:
        """Count what the samples of a run of pixels meet, of guides (n, spp, channels)."""
        inside, own = self.window.share(pixels, self.width)
        pixel = np.arange(own.start, own.stop).repeat(guides.shape[1])
        guides = guides[inside].reshape(-1, guides.shape[-1])
        shape, prim = (guides[:, GUIDES[k].start] for k in ("shape_index", "prim_index"))
        met = built.hit_ids(shape, prim)[:, 0] * (guides[:, 0] > 0)
        self.counts.append(add_coverage(pixel, met, np.ones(len(pixel))))

    def coverage(self) -> Coverage | None:
        """Share of each pixel's samples by object; None where none were counted."""
        if not self.counts:
            return None
        columns = [(each.pixel, each.object, each.share) for each in self.counts]
        pixel, met, count = map(np.concatenate, zip(*columns, strict=True))
        pixels = self.hit.shape[0] * self.hit.shape[1]
        return add_coverage(pixel, met, count * (pixels / count.sum()))


def make_layers(
    samples: Samples, built: BuiltScene, seconds: dict[str, float], statistics: dict[str, int]
) -> Layers:
    """Make the layers of a frame; small negatives left of the sky become 0 and are counted."""
    met = samples.hit[..., 0] > 0
    ids = built.hit_ids(samples.hit[..., 4], samples.hit[..., 5]) * met[..., None].astype(np.uint32)
    clamped = int(np.count_nonzero((samples.rgb < 0).any(axis=-1)))
    motion = None
    if built.description["after"]:
        motion = motion_vectors(samples.hit, built, samples.window)
    return Layers(
        rgb=np.maximum(samples.rgb, 0.0),
        Z=np.where(met, samples.hit[..., 0], SKY_Z),
        N=samples.hit[..., 1:4] * met[..., None],
        albedo=np.clip(samples.albedo, 0.0, 1.0),
        object=ids[..., 0],
        part=ids[..., 1],
        level=ids[..., 2],
        seconds=seconds,
        coverage=samples.coverage(),
        statistics={**statistics, "clamped": clamped, "replaced": samples.replaced},
        motion=motion,
    )
