"""Clustered, regular and mapped fields: the same cells, their laws, and the search."""

from functools import partial

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import cKDTree

from bench.counting import FLAT, Case, prototypes_of
from lod.camera import Corner
from lod.errors import InputError
from lod.pair_correlation import thomas
from lod.pruner import prune
from scenes.field.patterns import MappedCells, MaternCells, StemMap, ThomasCells, read_stems
from scenes.field.species_field import Species, SpeciesField

RNG = np.random.default_rng(5)
STEMS = StemMap(RNG.random((200, 2)) * (120.0, 90.0), np.array((120.0, 90.0)), "none")
PATTERNS = {
    "clusters": partial(ThomasCells, parents=4e-4, sigma=9.0),
    "regular": partial(MaternCells, core=7.0),
    "stems": partial(MappedCells, stems=STEMS),
}
K = {"clusters": 4e-3, "regular": 4e-3, "stems": STEMS.density}
NAMES = pytest.mark.parametrize("name", PATTERNS)


def cells_of(name, seed=0):
    return PATTERNS[name](seed, "tree", K[name])


def square(side, x=0, y=0):
    grid = np.meshgrid(np.arange(x, x + side), np.arange(y, y + side), indexing="ij")
    return tuple(axis.ravel() for axis in grid)


@NAMES
@settings(max_examples=25)
@given(x=st.integers(-(2**40), 2**40), seed=st.integers(0, 2**63 - 1))
def test_a_cell_always_holds_the_same_objects(name, x, seed):
    cells = cells_of(name, seed)
    block = cells.sample(*square(5, x, -3))
    for column in (x + 1, x + 4):
        one = cells.sample(np.array([column]), np.array([-1]))
        rows = (block.cell_x == column) & (block.cell_y == -1)
        assert np.array_equal(block.u[rows], one.u)
        assert np.array_equal(block.index[rows], one.index)
    assert ((block.u >= 0) & (block.u < 1)).all()
    names = np.stack((block.cell_x, block.cell_y, block.index), 1)
    assert len(np.unique(names, axis=0)) == len(block)


@NAMES
def test_density_is_what_is_asked_for_and_spare_numbers_are_uniform(name):
    cells = cells_of(name)
    many = 40 if name == "stems" else 100
    samples = cells.sample(*square(many))
    area = (many * cells.side_m) ** 2
    assert len(samples) / area == pytest.approx(K[name], rel=0.06)
    assert np.abs(np.corrcoef(samples.u[:, 2:].T) - np.eye(6)).max() < 0.05
    assert samples.u[:, 2:].mean(axis=0) == pytest.approx(0.5, abs=0.02)


def places(cells, many):
    samples = cells.sample(*square(many))
    return cells.positions(Corner(0, 0), samples)


def test_no_two_of_a_regular_field_are_nearer_than_the_core():
    xy = places(cells_of("regular"), 60)
    assert cKDTree(xy).query(xy, k=2)[0][:, 1].min() >= 7.0 - 1e-9


def test_clusters_have_the_pair_correlation_of_thomas():
    cells = cells_of("clusters")
    xy, side = places(cells, 80), 80 * cells.side_m
    inner = xy[((xy > 40) & (xy < side - 40)).all(axis=1)]
    edges = np.array([1e-9, 5.0, 10.0, 20.0, 40.0])
    pairs = np.diff(cKDTree(inner).count_neighbors(cKDTree(xy), edges))
    found = pairs / (len(inner) * K["clusters"] * np.pi * np.diff(edges**2))
    fine = np.linspace(0, 40, 4001)[1:]
    g = thomas(fine, 4e-4, 9.0)
    for low, high, each in zip(edges, edges[1:], found, strict=False):
        ring = (fine > low) & (fine <= high)
        assert each == pytest.approx(np.average(g[ring], weights=fine[ring]), rel=0.1)


def test_a_map_is_repeated_whole():
    cells = cells_of("stems")
    xy = places(cells, 30)
    for first in ((200.0, 300.0), (137.0, 41.0)):
        window = xy[((xy >= first) & (xy < np.array(first) + STEMS.period)).all(axis=1)]
        shifted = np.mod(window - window[0] + 1e-6, STEMS.period)
        assert len(window) == len(STEMS.xy)
        own = np.mod(STEMS.xy[:, None] - STEMS.xy + 1e-6, STEMS.period)
        order = np.lexsort(shifted.round(3).T)
        assert any(
            np.allclose(shifted[order], row[np.lexsort(row.round(3).T)], atol=1e-5)
            for row in own.transpose(1, 0, 2)
        )


@NAMES
def test_the_search_misses_nothing_and_both_pruners_agree(name):
    """Against every object of a block of cells that is far larger than the reach."""
    kinds = prototypes_of("figure", 1.0)
    view = Case("", "figure", "blake", 1.0, detail=20.0).view()
    field = SpeciesField(Species("tree", kinds, K[name], pattern=PATTERNS[name]), 3, FLAT)
    cut = prune(field, view)
    reach = int(200 / field.cells.side_m) + 2
    samples = field.cells.sample(*square(2 * reach, -reach, -reach))
    placed = field.instances_in_view(samples, view)
    every = field.prototypes.cut(placed, view, len(samples))
    assert 20 < cut.displayed_objects == every.displayed_objects < len(samples) / 2
    assert cut.displayed_parts == every.displayed_parts
    assert len(field.roots(view).position) >= cut.displayed_objects


HEAD = "# licence: CC0\n# window: 0 10 0 20\nx,y\n"


def test_a_map_is_read_with_its_licence(tmp_path):
    path = tmp_path / "stems.csv"
    path.write_text(HEAD + "1,2\n3.5,19,oak\n")
    found = read_stems(path)
    assert found.xy.tolist() == [[1, 2], [3.5, 19]]
    assert (found.licence, found.period.tolist(), found.density) == ("CC0", [10, 20], 0.01)


@pytest.mark.parametrize(
    ("text", "rule"),
    [
        ("# window: 0 10 0 20\n1,2\n3,4\n", "licence"),
        (HEAD + "1,2\n3,21\n", "all in the window"),
        (None, "can be read"),
    ],
)
def test_a_map_that_cannot_be_used_is_refused_in_one_line(tmp_path, text, rule):
    path = tmp_path / "stems.csv"
    if text is not None:
        path.write_text(text)
    with pytest.raises(InputError, match=rule):
        read_stems(path)


def test_a_core_that_leaves_no_room_is_refused():
    with pytest.raises(InputError, match="room"):
        MaternCells(0, "tree", 0.1, 2.0)
