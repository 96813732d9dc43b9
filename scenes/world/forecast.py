"""How much of a world will a view display? Foretold before any of it is pruned but the ground."""

from dataclasses import dataclass

from lod.pruner import Cut, prune
from lod.view import View
from scenes.field.forecast import forecast_field
from scenes.ground.mesh import QUADS
from scenes.world.world import World


@dataclass(frozen=True)
class Forecast:
    """Expected numbers of what a view visits and displays of a world.

    cells, objects   of the fields, visited; parts, sticks: displayed of them
    triangles        of the ground, and of the meshes displayed
    ground           the cut of the ground, from which its triangles are known
    """

    cells: float
    objects: float
    parts: float
    sticks: float
    triangles: float
    ground: Cut


def forecast(world: World, view: View, of_fields: View | None = None) -> Forecast:
    """Foretell what a view displays of the ground and of the fields.

    ``of_fields`` is the view of the fields where they are pruned by another rule than the ground.
    What is placed one by one, plumes, dust and what plug-ins make is left out. Raises InputError
    where the ground would have more tiles than it may.
    """
    fields = [forecast_field(each, of_fields or view) for each in world.fields]
    ground = prune(world.terrain, view)
    # A tile draws those of its quarters that no tile covers: 4 a tile, less one for each that does.
    patches = 3 * ground.displayed_parts + ground.displayed_objects
    return Forecast(
        cells=sum(each.cells for each in fields),
        objects=sum(each.objects for each in fields),
        parts=sum(each.parts for each in fields),
        sticks=sum(each.sticks for each in fields),
        triangles=2.0 * QUADS**2 * patches + sum(each.triangles for each in fields),
        ground=ground,
    )
