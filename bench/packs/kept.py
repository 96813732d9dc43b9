"""Parts that a method in another language keeps, rendered as lodbench renders any cut.

``kept.bin`` is KEPT_MAGIC and records of a part's number and how much wider it is drawn (KEPT), in
rising order of the numbers. Whatever owns a kept part is kept.
"""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np

from bench.packs.content import Content, load_content, whole_view
from bench.packs.make import RECIPE, read_pack
from bench.packs.part_file import KEPT, KEPT_MAGIC, read_tables
from lod.arrays import Ints, Reals
from lod.errors import InputError
from lod.pruner import BlendWeights, cross_fade, cut_from_parts, view_angles
from scenes.frame.frame_input import DisplayedRepresentation, FrameInput
from scenes.frame.layers import Layers
from scenes.render.render import build_frame, trace


def read_kept(path: Path, tables: dict[str, np.ndarray]) -> tuple[Ints, Reals]:
    """Read the numbers and widths of kept parts, (n,) each, and check them against a hierarchy.

    Raises InputError for a file of another layout, numbers that do not rise or are no part's, parts
    whose owner is not kept, and widths that are not above 0 or not 1 where nothing thins out.
    """
    data = path.read_bytes() if path.is_file() else b""
    body, where = data[len(KEPT_MAGIC) :], f"{path.name}"
    if not data.startswith(KEPT_MAGIC) or len(body) % KEPT.itemsize:
        rule = f"{KEPT_MAGIC.decode()} and records of {KEPT.itemsize} bytes"
        raise InputError("--kept", where, rule, "see docs/packs.md")
    rows = np.frombuffer(body, KEPT)
    part, width = rows["part"].astype(np.int64), rows["width"].astype(np.float64)

    def refuse(wrong: np.ndarray, rule: str) -> None:
        if wrong.any():
            raise InputError("--kept", f"{where}: part {int(part[np.argmax(wrong)])}", rule)

    instances, models = tables["instances"], tables["models"]
    total = int(instances["first"][-1]) + int(models["parts"][instances["model"][-1]])
    refuse(part >= total, f"the number of a part, below {total}")
    refuse(np.diff(part, prepend=-1) <= 0, "numbers rise, each once")
    refuse(~(np.isfinite(width) & (width > 0)), "a width above 0")
    owner, of = _owners(part, tables)
    found = np.searchsorted(part, owner)
    refuse((owner >= 0) & (part[np.minimum(found, len(part) - 1)] != owner), "its owner is kept")
    refuse((width != 1) & (models["thins"][of] == 0), "a width of 1: its model does not thin out")
    return part, width


def kept_input(content: Content, part: Ints, width: Reals) -> FrameInput:
    """Make the input of the still in which these parts alone are displayed, over the ground."""
    view, fields = whole_view(content.view), content.scene.world.fields
    shown, first = [content.made.displayed[0]], 0
    for field, every in zip(fields, content.made.displayed[1:], strict=True):
        tables, roots = field.prototypes.part_tables, every.cut.parts
        sizes = np.array([len(each) for each in tables.hierarchies])
        size = sizes[roots.state.instances.prototype]
        ends = first + np.cumsum(size)
        here = (part >= first) & (part < (ends[-1] if len(ends) else first))
        number, widths = part[here], width[here]
        copy = np.searchsorted(ends, number, side="right")
        row = number - (ends - size)[copy] + tables.root[roots.state.instances.prototype[copy]]
        owner = np.concatenate([each.parent for each in tables.hierarchies])[row]
        local = row - tables.root[roots.state.instances.prototype[copy]]
        parent = np.where(owner < 0, -1, np.searchsorted(number, number - local + owner))
        parts = field.prototypes.parts(roots.state, copy, row, parent, view)
        inner, leaf, hidden = cross_fade(parent, parts.share, widths)
        weights = BlendWeights(inner, leaf, *view_angles(parts.position, content.view), hidden)
        cut = cut_from_parts(parts, len(roots), len(parts))
        shown.append(DisplayedRepresentation(field.name, cut, field.appearance(parts, weights)))
        first = int(ends[-1]) if len(ends) else first
    return replace(content.made, displayed=tuple(shown))


def render_kept(
    folder: Path, kept: Path, frame: int = 0, spp: int = 64, seed: int = 0
) -> tuple[Layers, dict[str, int]]:
    """Render kept parts of a pack; gives the layers, and what is displayed.

    frame   of the walk, from 1; 0 = the still
    Raises InputError for a folder that is no finished pack, and as ``read_kept``.
    """
    read_pack(folder)
    recipe = json.loads((folder / RECIPE).read_text("utf-8"))
    part, width = read_kept(kept, read_tables(folder / "parts.bin"))
    content = load_content(recipe["preset"], tuple(recipe["settings"]), tuple(recipe["size"]))
    made = kept_input(content, part, width)
    if frame:
        made = replace(made, camera=content.camera(frame))
    layers = trace(build_frame(made), replace(made.quality, spp=spp, seed=seed), frame)
    return layers, {"parts": len(part), **layers.statistics}


def _owners(part: Ints, tables: dict[str, np.ndarray]) -> tuple[Ints, Ints]:
    """Return the number of each part's owner, -1 of a whole, and the model of each, (n,)."""
    instances, models = tables["instances"], tables["models"]
    copy = np.searchsorted(instances["first"], part, side="right") - 1
    first, model = instances["first"][copy].astype(np.int64), instances["model"][copy]
    parent = tables["parts"]["parent"][models["first_part"][model] + part - first]
    return np.where(parent < 0, -1, first + parent), model.astype(np.int64)
