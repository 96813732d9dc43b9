"""Objects keep their keys from frame to frame; a key finds the object again."""

import numpy as np
import pytest

from scenes.presets.load import load_preset
from scenes.render.object_keys import identities
from scenes.scene import Scene
from tests.scenes.field.brute_force import instances_in_cells

TOML = """
seed = 11
[camera]
speed = 200
[terrain]
reach = 200
[species.figure]
model = "figure"
density = 0.01
prototypes = 1
[species.tree]
model = "tree"
density = 0.002
prototypes = 1
[placed.joe]
model = "figure"
position = [0.0, 9.0]
[render]
size = "32x18"
"""


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    path = tmp_path_factory.mktemp("preset") / "a.toml"
    path.write_text(TOML)
    preset = load_preset(str(path))
    return Scene(preset)


def test_every_displayed_id_is_explained_and_no_other(scene):
    made = scene.input(1, "scalar_rgb")
    from scenes.render.description import describe_frame

    drawn_as = describe_frame(made)
    drawn = {
        int(drawn_as["ids"][row, 0]) for rows in drawn_as["owners"].values() for row in set(rows)
    }
    known = {each.object: each for each in identities(scene, 1)}
    assert drawn and drawn <= set(known)
    assert {each.of for each in known.values()} == {"terrain", "figure", "tree", "joe"}
    assert all((each.key is None) == (each.of in ("terrain", "joe")) for each in known.values())


def test_a_key_is_the_same_in_another_frame_where_the_id_is_not(scene):
    first, second = (
        {each.key: each for each in identities(scene, frame) if each.key} for frame in (1, 13)
    )
    both = first.keys() & second.keys()
    assert len(both) > 20 and len(first) > len(both)
    assert all(first[key].cell == second[key].cell for key in both)
    assert all(first[key].name == second[key].name for key in both)
    assert len({each.name for each in first.values()}) == len(first)
    assert any(first[key].object != second[key].object for key in both)


def test_cell_and_number_find_the_object_where_it_stands(scene):
    figures = next(each for each in scene.world.fields if each.name == "figure")
    corner = scene.view(1).camera.corner
    made = scene.input(1, "scalar_rgb")
    names = [v.name for v in made.displayed]
    shown = made.displayed[names.index("figure")].cut
    known = [each for each in identities(scene, 1) if each.of == "figure"]
    assert len(known) == len(np.unique(shown.object))
    instances = shown.parts.state.instances
    first = known[0].object - int(np.unique(shown.object)[0])
    for each in known:
        cell = np.array([each.cell[0]]), np.array([each.cell[1]])
        there = instances_in_cells(figures, corner, *cell)
        row = np.flatnonzero(there.samples.index == each.index)
        assert len(row) == 1
        assert np.allclose(there.instances.origin[row[0]], instances.origin[each.object - first])
