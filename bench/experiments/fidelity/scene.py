"""What does the fidelity experiment look at? Three views of a finite world, pruned in many ways.

The reference is the unpruned window with the ground at GROUND_DETAIL, where every tile in view is
as fine as it gets. Off-screen casters are the objects wholly out of view: only their shadows and
bounced light are seen.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from lod.errors import InputError
from lod.pruning.pruner import Cut, cut_from_parts, prune
from lod.pruning.representation import Representation
from lod.pruning.view import View
from lod.pruning.view_geometry import in_view
from scenes.frame.displayed import DisplayedRepresentation, display
from scenes.plugins.entry_points import metric_by_name
from scenes.preset.load import load_preset
from scenes.preset.tables import Preset
from scenes.world.view import view_at
from scenes.world.world import World, build_world

VIEWS = {
    "eye level": (),
    "aerial": ("camera.height=40", "camera.pitch=-25"),
    "hazy": ("air.visibility=200m",),
}
METRICS_TRIED = ("blake", "bounded", "solid_angle", "depth")

SPECIES, GROUND = "species", "ground"
"""What is pruned in the sweeps: species on whole ground, or the ground alone.

The ground is pruned by the default metric. A law is known of species, and not of the ground.
"""

PIECES = ("objects", "casters", "no casters", "everything")
"""What is pruned at PIECES_DETAIL by the default metric, while the rest is the reference's.

The pieces are the objects in view; the casters out of view; no casters, which are then left out;
and everything, with the ground.
"""

PIECES_DETAIL = 1.0
GROUND_DETAIL = 1 / 32
MOST_PARTS = 500_000
"""The most parts that a reference may have."""

WORLD = (
    "world.extent=240",
    "camera.heading=140",
    "terrain.reach=256",
    "terrain.finest=1",
    "terrain.amplitude=4",
    "terrain.wavelength=256",
    "species.figure.density=0.004",
    "species.figure.prototypes=4",
    "species.tree.density=0.0006",
    "species.tree.prototypes=2",
    "render.size=64x36",
    "render.max_depth=3",
)


@dataclass(frozen=True)
class Case:
    """One way to prune one view; ``pruned`` is SPECIES, GROUND or one of PIECES."""

    view: str
    metric: str
    detail: float
    pruned: str = SPECIES


def tried_metrics(metric: str | None = None) -> tuple[str, ...]:
    """Return the metrics that are tried, with ``metric`` among them."""
    return (*METRICS_TRIED, *([metric] if metric else []))


def grid_cases(
    details: Sequence[float], ground_details: Sequence[float], metric: str | None = None
) -> list[Case]:
    """Return every view by every metric and detail, and the pieces that are pruned alone.

    ``ground_details`` are the details [px] at which the ground alone is pruned; ``metric`` is tried
    beside the others.
    """
    made = [Case(v, m, d) for v in VIEWS for m in tried_metrics(metric) for d in details]
    made += [Case(v, "blake", d, GROUND) for v in VIEWS for d in ground_details]
    return made + [Case(v, "blake", PIECES_DETAIL, piece) for v in VIEWS for piece in PIECES]


def preset_of(view: str) -> Preset:
    """Load the preset ``meadow`` in a window, as the view sees it."""
    return load_preset("meadow", (*WORLD, *VIEWS[view]))


@lru_cache(maxsize=1)
def world() -> World:
    """Build the world of all views, which differ in camera and air alone."""
    return build_world(preset_of("eye level"))


def view_of(case: Case) -> View:
    """Return the view of a case: its preset's, with the metric and detail of the case."""
    plain = view_at(world(), preset_of(case.view), 1)
    return replace(plain, metric=metric_by_name(case.metric), detail=case.detail)


@lru_cache(maxsize=len(VIEWS))
def reference(view: str) -> tuple[DisplayedRepresentation, ...]:
    """Display everything, with the ground as fine as it gets.

    Raises InputError for more than MOST_PARTS parts.
    """
    made = []
    for each in world().representations:
        full = _full(each, view)
        made.append(_visible(each, full, prune(each, full)))
    if parts_in(made) > MOST_PARTS:
        raise InputError("reference", parts_in(made), f"at most {MOST_PARTS} parts")
    return tuple(made)


def displayed(case: Case) -> list[DisplayedRepresentation]:
    """Return what is displayed in the picture of a case."""
    view, made = view_of(case), []
    for each in world().representations:
        ground = each is world().terrain
        if case.pruned in ("everything", GROUND if ground else SPECIES):
            made.append(_visible(each, view, prune(each, view)))
        elif ground or case.pruned == GROUND:
            made += [whole for whole in reference(case.view) if whole.name == each.name]
        else:
            made += _pieces(each, case, view)
    return made


def _pieces(each: Representation, case: Case, view: View) -> list[DisplayedRepresentation]:
    """Display a species: its objects in view and out of view, pruned or not as the case says."""
    full = _full(each, case.view)
    pruned, whole = prune(each, view), prune(each, full)
    inside, outside = ((pruned, view), (whole, full))
    if case.pruned != "objects":
        inside, outside = outside, inside
    made = [_visible(each, inside[1], _objects(inside[0], view, True))]
    if case.pruned != "no casters":
        made.append(_visible(each, outside[1], _objects(outside[0], view, False)))
    return made


def _objects(cut: Cut, view: View, seen: bool) -> Cut:
    """Return the part of a cut whose objects are in view, or are not."""
    parts = cut.parts
    roots = np.flatnonzero(parts.parent < 0)
    inside = np.zeros(int(parts.object.max(initial=-1)) + 1, bool)
    inside[parts.object[roots]] = in_view(view, parts.centre[roots], parts.bound[roots])
    rows = np.flatnonzero(inside[parts.object] == seen)
    place = np.full(len(parts) + 1, -1)  # the last for what has no whole
    place[rows] = np.arange(len(rows))
    taken = parts.take(rows)
    return cut_from_parts(replace(taken, parent=place[taken.parent]), 0, 0)


def _full(each: Representation, view: str) -> View:
    """Return the view that displays all parts of a representation."""
    ground = each is world().terrain
    found = view_of(Case(view, "blake" if ground else "full", GROUND_DETAIL if ground else 1.0))
    return replace(found, fade=0.0, conditions=None, offscreen_detail=1.0)


def _visible(each: Representation, view: View, cut: Cut) -> DisplayedRepresentation:
    return display(each, cut, view)


def parts_in(visible: Sequence[DisplayedRepresentation]) -> int:
    """Count the parts of the species; tiles of the ground are not parts that a law knows."""
    return sum(len(each.cut) for each in visible if each.name != world().terrain.name)
