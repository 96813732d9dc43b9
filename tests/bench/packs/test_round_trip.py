"""A world written as USD by a pack's writer is read again as a model: counts, limits, colours."""

from pathlib import Path

import numpy as np
import pytest
from pxr import UsdGeom

from bench.packs import usd_scene
from bench.packs.content import Content
from scenes.imported.imported_prototype import imported_prototype
from scenes.imported.library import read_model
from scenes.render.description import Copies
from scenes.render.usd_export import set_mesh


def leaf(rng: np.random.Generator, triangles: int) -> dict:
    """A described mesh whose triangles have a colour each."""
    corners = rng.uniform(0, 1, (3 * triangles, 3)).astype(np.float32)
    colours = np.repeat(rng.uniform(0.1, 0.9, (triangles, 3)), 3, axis=0).astype(np.float32)
    faces = np.arange(3 * triangles, dtype=np.uint32).reshape(-1, 3)
    normals = np.tile(np.float32((0, 0, 1)), (len(corners), 1))
    mesh = {"vertices": corners, "normals": normals, "colours": colours, "faces": faces}
    return {"type": "mesh", **mesh}


@pytest.mark.slow
def test_a_round_trip_keeps_counts_limits_and_colours(tmp_path: Path) -> None:
    rng = np.random.default_rng(5)
    ground, models = leaf(rng, 4), [leaf(rng, 2), leaf(rng, 3)]
    angles, which = rng.uniform(-3, 3, 6), np.array((0, 1, 1, 0, 1, 0))
    turn = np.stack((np.cos(angles), np.sin(angles)), axis=1)
    place = rng.uniform(-9, 9, (6, 3))
    copies = Copies([[(each, np.zeros(0))] for each in models], which, place, turn)
    content = object.__new__(Content)  # of which only what is there is drawn
    description = {"shapes": {"ground": ground}, "copies": copies}
    content.__dict__.update(description=description, levels=[[], []])
    usd_scene.write_geometry(tmp_path / "pack.usdc", content)

    # The same, each copy a mesh of its own.
    stage = usd_scene._stage(str(tmp_path / "plain.usdc"))
    set_mesh(stage, "/pack/ground", ground)
    UsdGeom.Xform.Define(stage, "/pack/instances")
    for n, ((c, s), at, k) in enumerate(zip(turn, place, which.tolist(), strict=True)):
        matrix = np.float64(((c, -s, 0), (s, c, 0), (0, 0, 1)))
        moved = (models[k]["vertices"] @ matrix.T + at).astype(np.float32)
        UsdGeom.Xform.Define(stage, f"/pack/instances/m{k:03d}_{n}")
        place_of = f"/pack/instances/m{k:03d}_{n}/mesh0"
        set_mesh(stage, place_of, {**models[k], "vertices": moved})
    stage.GetRootLayer().Save()

    one, other = (read_model(tmp_path / name) for name in ("pack.usdc", "plain.usdc"))
    assert one.names == other.names
    assert len(one.meshes) == len(other.meshes) == 4 + 2 * 3 + 3 * 3
    np.testing.assert_allclose(one.meshes.vertices, other.meshes.vertices, atol=1e-5)
    np.testing.assert_array_equal(one.meshes.colours, other.meshes.colours)
    mine, plain = (imported_prototype("pack", each).hierarchy for each in (one, other))
    for name in ("P", "R", "B", "level", "parent", "position"):
        np.testing.assert_allclose(getattr(mine, name), getattr(plain, name), atol=1e-4)
