"""Make a pack: write what is missing of its files, each whole, and what they add up to last.

``recipe.json`` says what a folder was made from. The same command goes on where it was stopped; a
folder of another recipe is refused. ``pack.json`` is written when all else is there.
"""

import hashlib
import json
import os
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from bench.experiment import Progress
from bench.images.differences import BAND_EDGES_M
from bench.packs import part_file, pbrt, usd_scene
from bench.packs.content import WALK_FRAMES, WALK_SIZE, Content, load_content, settings_of
from bench.packs.reference import render_reference
from bench.templates import filled
from lod.air import rgb_extinction
from lod.camera import Camera
from lod.errors import InputError
from scenes.files import make_folder, whole_file, write_text
from scenes.processes.ownership import owned
from scenes.render import variants
from scenes.render.description import FAR_M, NEAR_M
from scenes.render.exr.header import software
from scenes.render.exr.layer_file import write_channels
from scenes.render.memory import preflight
from scenes.render.render import BuiltFrame, build_frame, move_camera

_HERE = Path(__file__).parent

FORMAT = 1
RECIPE, PACK, SUMS = "recipe.json", "pack.json", "SHA256SUMS"
STILL = "reference/still.exr"

SKY_ROWS, SKY_SIDE, SKY_AA = 256, 256, 4
"""Rows of the picture of the sky by latitude; the side of the one of equal areas; and directions
along each side of a pixel, of which it is the mean."""


class Recipe(NamedTuple):
    """What a pack is made from: the same gives the same files on one machine."""

    pack: str
    size: tuple[int, int]
    spp: int

    def as_json(self) -> dict[str, Any]:
        """Return it as plain data, with the preset and the settings that the name stands for."""
        preset, settings = settings_of(self.pack)
        made = {"preset": preset, "settings": list(settings), "software": software()}
        return {**self._asdict(), "size": list(self.size), "format": FORMAT, **made}


def make_pack(
    folder: Path, recipe: Recipe, walk: bool, most_bytes: int | None, progress: Progress
) -> dict[str, Any]:
    """Make what is missing of a pack in a folder, and return what ``pack.json`` says.

    Raises InputError for a folder of another recipe, or one that another process is making, and
    where the pack is estimated to need more memory than ``most_bytes``.
    """
    plain = recipe.as_json()
    for each in (folder, folder / "sky", folder / "reference"):
        make_folder(each)
    with owned(folder, f"pack {os.getpid()}", "makes a pack"):
        _check_recipe(folder / RECIPE, plain)
        progress(0, 1, "world")
        content = load_content(plain["preset"], tuple(plain["settings"]), recipe.size)
        variant = content.made.quality.variant
        preflight(content.scene, (1,), most_bytes, variant)
        variants.use(variant)
        light = _light(content)
        steps = [*_files(content, light, plain), *_references(content, recipe, walk)]
        for number, (name, write) in enumerate(steps):
            progress(number, len(steps), name)
            if not (folder / name).exists():
                write(folder / name)
        found = _numbers(folder, content, plain, light)
        write_text(folder / PACK, _json(found))
        write_text(folder / "README.md", _readme(folder, found))
        write_text(folder / SUMS, "".join(_sums(folder)))
    return found


def read_pack(folder: Path) -> dict[str, Any]:
    """Read ``pack.json`` of a finished pack.

    Raises InputError where there is none, and where it or the recipe is not as it was written.
    """
    try:
        found: dict[str, Any] = json.loads((folder / PACK).read_text("utf-8"))
        written = (folder / SUMS).read_text("utf-8").splitlines()
        kept = {_sum(folder / name, name) for name in (PACK, RECIPE)}
        whole = found["format"] == FORMAT and kept <= set(written)
    except (OSError, ValueError, TypeError, KeyError, RecursionError):
        whole = False
    if whole:
        return found
    rule = f"the folder of a finished pack of format {FORMAT}, as its {SUMS} says"
    cure = "make one with `lodbench pack make crowd-small -o DIR`"
    raise InputError("DIR", str(folder), rule, cure)


def _check_recipe(path: Path, plain: dict[str, Any]) -> None:
    if not path.exists():
        if others := [each.name for each in path.parent.iterdir() if each.is_file()]:
            rule = "an empty folder, or that of the same pack"
            raise InputError("-o", others[0], rule, "choose another folder")
        write_text(path, _json(plain))
    found = json.loads(path.read_text("utf-8"))
    for key in plain:
        if found.get(key) != plain[key]:
            rule = f"a folder whose {key} is {plain[key]!r}"
            raise InputError("-o", found.get(key), rule, "choose another folder")


Step = tuple[str, Callable[[Path], object]]  # a file of a pack, and what writes it


def _whole(write: Callable[[Path], object]) -> Callable[[Path], object]:
    def made(path: Path) -> None:
        with whole_file(path) as temporary:
            write(temporary)

    return made


def _files(content: Content, light: dict[str, Any], plain: dict[str, Any]) -> Iterator[Step]:
    """All files but the references; the geometry before what refers to it."""
    sky = content.description["light"]
    notes = {"software": software(), "pack": plain["pack"], "haze": _json(_haze(content))}

    def exr(name: str, picture: Callable[[], np.ndarray], kind: Any = np.float32) -> Step:
        def write(path: Path) -> None:
            made = picture().astype(kind)
            write_channels(path, {c: made[..., k] for k, c in enumerate("RGB")})

        return name, _whole(write)

    yield exr("sky/latlong.exr", lambda: _sky(sky, _latlong))
    yield exr("sky/equalarea.exr", lambda: _sky(sky, _equal_area))
    yield exr("sky/airlight.exr", lambda: _airlight(sky))
    yield exr(pbrt.ATLAS, lambda: pbrt.ground_atlas(content.ground), np.float16)
    yield "geometry.usdc", _whole(lambda path: usd_scene.write_geometry(path, content))
    yield "scene.usda", _whole(lambda path: usd_scene.write_scene(path, content, light, notes))
    yield "geometry.pbrt.gz", _whole(lambda path: pbrt.write_geometry(path, content))
    cameras = {"still": content.made.camera}
    cameras |= {f"walk.{n:04d}": content.camera(n) for n in range(1, WALK_FRAMES + 1)}
    for name, camera in cameras.items():
        text = pbrt.camera_text(camera, light["sun_irradiance"], light["to_sun"])
        yield f"{name}.pbrt", lambda path, text=text: write_text(path, text)  # type: ignore[misc]
    tables = part_file.hierarchy_tables
    yield "parts.bin", _whole(lambda path: part_file.write_tables(path, tables(content)))
    yield "LICENSE", lambda path: write_text(path, (_HERE / "LICENSE.txt").read_text("utf-8"))


def _references(content: Content, recipe: Recipe, walk: bool) -> Iterator[Step]:
    """The reference of the still, and those of the walk; each has its numbers beside it."""
    built: list[BuiltFrame] = []

    def writer(camera: Camera, halves: bool, frame: int) -> Callable[[Path], object]:
        def write(path: Path) -> None:
            if not built:
                built.append(build_frame(content.made))
            placed = move_camera(built[0], camera, content.scene.air)
            channels, about = render_reference(placed, content.made.quality, recipe.spp, halves)
            _whole(lambda file: write_channels(file, channels))(path)
            write_text(path.with_suffix(".json"), _json({"frame": frame, **about}))

        return write

    yield STILL, writer(content.made.camera, False, 0)
    for n in range(1, WALK_FRAMES + 1 if walk else 1):
        yield f"reference/walk.{n:04d}.exr", writer(content.camera(n), True, n)


def _light(content: Content) -> dict[str, Any]:
    from scenes.render.light import sun_irradiance

    described = content.description["light"]
    return {
        "to_sun": described["to_sun"].tolist(),
        "sun_irradiance": sun_irradiance(described).tolist(),
        "turbidity": described["turbidity"],
        "sky": {name: f"sky/{name}.exr" for name in ("latlong", "equalarea", "airlight")},
    }


def _haze(content: Content) -> dict[str, Any]:
    from scenes.render.haze import HORIZON_DEG

    return {"beta": rgb_extinction(content.scene.air).tolist(), "horizon_deg": HORIZON_DEG}


def _airlight(light: dict[str, Any]) -> np.ndarray:
    from scenes.render.haze import horizon

    return horizon(light)[None]


def _sky(light: dict[str, Any], towards: Callable[[], np.ndarray]) -> np.ndarray:
    """Return the radiance of the sky above the horizon, each pixel the mean of its directions."""
    from scenes.render.light import sky_radiance

    fine = towards()
    seen = sky_radiance(light, fine.reshape(-1, 3)).reshape(fine.shape)
    seen *= fine[..., 2:] > 0
    height, width = (each // SKY_AA for each in fine.shape[:2])
    found: np.ndarray = seen.reshape(height, SKY_AA, width, SKY_AA, 3).mean(axis=(1, 3))
    return found


def _latlong() -> np.ndarray:
    """Directions of pixels by latitude and longitude as OpenEXR has them, turned to z up.

    Rows from the zenith down; longitudes fall from +π to −π: 0 is south and +π/2 is east.
    """
    rows = SKY_ROWS * SKY_AA
    up = np.pi * (0.5 - (np.arange(rows) + 0.5) / rows)
    turn = np.pi * (1 - (np.arange(2 * rows) + 0.5) / rows)
    e, a = np.meshgrid(up, turn, indexing="ij")
    return np.stack((np.sin(a) * np.cos(e), -np.cos(a) * np.cos(e), np.sin(e)), axis=-1)


def _equal_area() -> np.ndarray:
    """Directions of pixels of Clarberg's equal-area octahedral map (2008), as pbrt-v4 has it."""
    side = SKY_SIDE * SKY_AA
    at = 2 * (np.arange(side) + 0.5) / side - 1
    v, u = np.meshgrid(at, at, indexing="ij")
    signed = 1 - (np.abs(u) + np.abs(v))
    r = 1 - np.abs(signed)
    phi = (
        (np.where(r == 0, 0.0, (np.abs(v) - np.abs(u)) / np.where(r == 0, 1.0, r)) + 1) * np.pi / 4
    )
    z, level = np.copysign(1 - r * r, signed), r * np.sqrt(np.maximum(2 - r * r, 0.0))
    x, y = np.copysign(np.cos(phi), u) * level, np.copysign(np.sin(phi), v) * level
    return np.stack((x, y, z), axis=-1)


def _numbers(
    folder: Path, content: Content, plain: dict[str, Any], light: dict[str, Any]
) -> dict[str, Any]:
    known = {p.stem: json.loads(p.read_text("utf-8")) for p in folder.glob("reference/*.json")}
    low, high = content.bounds()
    fields, quality = content.scene.world.fields, content.made.quality
    objects = {f.name: len(d.cut) for f, d in zip(fields, content.made.displayed[1:], strict=True)}
    frames = [_stand(content.camera(n)) for n in range(1, WALK_FRAMES + 1)]
    still = content.made.camera
    return {
        **{key: plain[key] for key in ("pack", "format", "software")},
        "objects": objects,
        **content.counts(),
        "bounds_m": [low, high],
        "camera": {
            "projection": "perspective",
            "fov_axis": "x",
            "fov_deg": float(np.degrees(still.fov_x)),
            "near_m": NEAR_M,
            "far_m": FAR_M,
            "still": {"size": [still.width, still.height], **_stand(still)},
            "walk": {"size": list(WALK_SIZE), "fps": 24.0, "frames": frames},
        },
        "light": light,
        "haze": _haze(content),
        "integrator": {"max_depth": quality.max_depth, "filter": "box"},
        "bands_m": list(BAND_EDGES_M),
        "references": {
            "still": known.pop("still", None),
            "walk": [known[key] for key in sorted(known)],
        },
    }


def _stand(camera: Camera) -> dict[str, list[float]]:
    return {name: getattr(camera, name).tolist() for name in ("eye", "forward", "up")}


def _json(data: Any) -> str:
    return json.dumps(data, indent=1, allow_nan=False) + "\n"


def _all_files(folder: Path) -> list[tuple[str, Path]]:
    found = [(p.relative_to(folder).as_posix(), p) for p in folder.rglob("*") if p.is_file()]
    return sorted(each for each in found if not each[0].startswith(".") and each[0] != SUMS)


def _sums(folder: Path) -> Iterator[str]:
    """Write a line for each file, as ``sha256sum`` writes and reads them."""
    return (f"{_sum(path, name)}\n" for name, path in _all_files(folder))


def _sum(path: Path, name: str) -> str:
    with path.open("rb") as file:
        return f"{hashlib.file_digest(file, 'sha256').hexdigest()}  {name}"


def _readme(folder: Path, found: dict[str, Any]) -> str:
    sizes = {k: path.stat().st_size for k, path in _all_files(folder) if k != "README.md"}
    objects = ", ".join(f"{n} {name}" for name, n in found["objects"].items())
    beta = ", ".join(f"{each:.3g}" for each in found["haze"]["beta"])
    page = _HERE / "README.md.jinja"
    return filled(page, **found, listed=objects, beta=beta, sizes=sizes)
