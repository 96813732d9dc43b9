"""`lodbench model`: other people's models as species of a field, shown down to each level."""

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
import numpy as np
from PIL import Image

from bench.cli.flags import StrictCommand
from bench.cli.output import Output, table
from lod.air import CLEAR
from lod.camera import Camera, Corner, camera_from_heading
from lod.errors import InputError
from lod.metric import METRICS
from lod.pruner import Parts, cut_from_parts, prune
from lod.view import View
from scenes.field.species_field import Placed
from scenes.frame.frame_input import FrameInput, Light, Quality, display
from scenes.frame.layers import Layers
from scenes.ground.mesh import Terrain
from scenes.processes.progress import kernels_told, steps, tell, work
from scenes.render.pictures import PictureStyle, preview_pixels, save_sheet
from scenes.render.render import render_frame
from scenes.rig.rigged_prototype import RiggedPrototype

if TYPE_CHECKING:
    from scenes.imported.part_tree import PartTree


_sheet = click.option(
    "-o", "sheet", metavar="SHEET.png", help="Where a picture of every level goes."
)


@click.group("model")
def command() -> None:
    """Bring models of your own: USD or glTF scenes whose node tree is the part hierarchy."""


@command.command("add", cls=StrictCommand)
@click.argument("file", metavar="FILE")
@click.option("--name", metavar="NAME", help="What presets call it; by default as the file.")
@click.option("--overwrite", is_flag=True, help="Replace a model of that name.")
@_sheet
def add(file: str, name: str | None, overwrite: bool, sheet: str | None, out: Output) -> None:
    """Read and check a .usd, .usda, .usdc, .usdz, .gltf or .glb file, and keep it as a model."""
    from scenes.imported.library import keep_model, place_of_model

    tree = _read(out, file)
    called = name or Path(file).stem
    path = place_of_model(called, overwrite)
    path.parent.mkdir(parents=True, exist_ok=True)
    _picture(out, called, tree, Path(sheet) if sheet else path.with_suffix(".png"))
    keep_model(called, tree, overwrite)  # last: a command that fails keeps nothing
    _tell(out, called, tree)
    out.note(f"{path} holds it: a preset's species has it by model = {called!r}")


@command.command("list", cls=StrictCommand)
def list_models(out: Output) -> None:
    """List the models that were added."""
    from scenes.imported.library import user_model
    from scenes.model_files import models_folder, user_model_names

    found = {}
    for name in user_model_names():
        try:
            found[name] = _facts(user_model(name))
        except (InputError, OSError) as error:
            out.note(f"lodbench: {error}")
    out.record({"models": found})
    rows = [
        (name, each["parts"], each["levels"], each["triangles"], each["height_m"])
        for name, each in found.items()
    ]
    if rows:
        out.say(table([("model", "parts", "levels", "triangles", "height [m]"), *rows]))
    else:
        out.say(f"none in {models_folder()}: `lodbench model add FILE` adds one")


@command.command("show", cls=StrictCommand)
@click.argument("model", metavar="NAME|FILE")
@_sheet
def show(model: str, sheet: str | None, out: Output) -> None:
    """Show what a model holds, level by level; a file is read and checked, and not kept."""
    from scenes.imported.library import user_model
    from scenes.model_files import is_model_file

    is_file = is_model_file(model) or "/" in model
    tree = _read(out, model) if is_file else user_model(model)
    _tell(out, model, tree)
    if sheet:
        _picture(out, model, tree, Path(sheet))


@command.command("remove", cls=StrictCommand)
@click.argument("name", metavar="NAME")
def remove(name: str, out: Output) -> None:
    """Remove a model that was added; presets that name it are refused from then on."""
    from scenes.imported.library import remove_model

    remove_model(name)
    out.record({"removed": name})
    out.say(f"{name} is removed")


def _read(out: Output, file: str) -> "PartTree":
    from scenes.imported.library import read_model

    with work(f"reading {Path(file).name}", 1):
        tell()
        return read_model(Path(file), out.note)


def _picture(out: Output, name: str, tree: "PartTree", path: Path) -> None:
    from scenes.imported.imported_prototype import imported_prototype
    from scenes.render.variants import choose

    with kernels_told():
        with work("fitting appearances", 1):
            tell()
            prototype = imported_prototype(name, tree)
        sheet = model_sheet(prototype, path, choose("auto"))
    out.note(f"{sheet} shows its levels")


def _facts(tree: "PartTree") -> dict[str, Any]:
    low, high = tree.meshes.vertices.min(axis=0), tree.meshes.vertices.max(axis=0)
    return {
        "sha256": tree.digest,
        "parts": len(tree),
        "levels": int(tree.level.max()) + 1,
        "triangles": len(tree.meshes),
        "height_m": float(high[2]),
        "low": low.tolist(),
        "high": high.tolist(),
        "turns": tree.turning,
    }


def _tell(out: Output, name: str, tree: "PartTree") -> None:
    facts = _facts(tree)
    parts = np.bincount(tree.level)
    triangles = np.bincount(tree.level, tree.meshes.count).astype(int)
    levels = [
        {"level": level, "parts": int(n), "triangles": int(triangles[level])}
        for level, n in enumerate(parts.tolist())
    ]
    found = np.unique(tree.meshes.face_colours.round(4), axis=0, return_counts=True)
    colours = [{"albedo": row.tolist(), "triangles": int(n)} for row, n in zip(*found, strict=True)]
    out.record({"model": name, **facts, "by_level": levels, "colours": colours})
    size = " by ".join(f"{x:.3g}" for x in np.subtract(facts["high"], facts["low"]))
    lead = f"{name}: {facts['parts']:,} parts, {facts['triangles']:,} triangles, {size} m"
    bottom = f"lowest point {facts['low'][2]:.3g} m above the ground"
    rows: list[tuple[Any, ...]] = [("level", "parts", "triangles", "such as")]
    for each in levels:
        rows += [
            (each["level"], each["parts"], each["triangles"], tree.names[row])
            for row in np.flatnonzero(tree.level == each["level"])[:1].tolist()
        ]
    out.say(f"{lead}, {bottom}\n{table(rows)}\n  sha256 {facts['sha256']}")


SIDE = 240  # pixels of each picture, to either side

_FOV_DEG, _PITCH_DEG, _HEADING_DEG = 30.0, -12.0, 35.0


def model_sheet(prototype: RiggedPrototype, out_png: str | Path, variant: str) -> Path:
    """Write one picture of each level above another, both in light and by level, as a PNG.

    ``variant`` is a Mitsuba variant that works here.
    """
    flat = Terrain(seed=0, amplitude=0.0, wavelength=8.0, hurst=0.9, reach=64.0, finest=1.0)
    model = Placed("model", prototype, 0.0, 0.0, 0.0, flat)
    view = View(_camera(prototype), METRICS["full"])
    whole = prune(model, view).parts
    levels = range(int(whole.level.max()) + 1)
    frames = []
    with work("rendering a picture of each level", len(levels)):
        for level in levels:
            tell()
            with steps(1):
                frames.append(_frame(model, whole, level, view, variant))
    exposure = PictureStyle().exposure_of(frames[-1].rgb)
    tiles = [
        Image.fromarray(preview_pixels(layers, PictureStyle(view=kind), exposure, {}))
        for kind in ("colour", "level")
        for layers in frames
    ]
    labels = [f"level {level}" for level in levels] * 2
    return save_sheet(tiles, labels, len(frames), out_png)


def _camera(prototype: RiggedPrototype) -> Camera:
    tree = prototype.hierarchy
    away = float(tree.B[0]) / np.sin(np.radians(_FOV_DEG / 2))
    a, b = np.radians(_HEADING_DEG), np.radians(_PITCH_DEG)
    ahead = np.array((np.sin(a) * np.cos(b), np.cos(a) * np.cos(b), np.sin(b)))
    middle = np.array((-tree.position[0, 1], tree.position[0, 0], tree.position[0, 2]))
    eye, size = middle - away * ahead, (SIDE, SIDE)
    return camera_from_heading(Corner(0, 0), eye, _HEADING_DEG, _PITCH_DEG, _FOV_DEG, size)


def _frame(model: Placed, whole: Parts, level: int, view: View, variant: str) -> Layers:
    shown = whole.level <= level
    row = np.cumsum(shown) - 1
    parts = whole.take(shown)
    parts = replace(parts, parent=np.where(parts.parent < 0, -1, row[parts.parent]))
    cut = cut_from_parts(parts, 1, len(parts))
    light, quality = Light(200.0, 40.0), Quality(variant, spp=16)
    it = replace(display(model, cut, view), posing=None)
    return render_frame(FrameInput(view.camera, (it,), CLEAR, light, quality))
