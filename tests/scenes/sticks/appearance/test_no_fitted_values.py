"""No file holds a value that was fitted to a model: a fit needs its shapes and albedos alone.

The data files of the packages are presets, botany, anatomy, golden counts (which
``tests/bench/count`` counts again) and the sky's table (``bench.calibrate.sky_table``).
"""

import subprocess
import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np

from scenes.models.trees.species_files import tree_species
from scenes.models.trees.tree import tree_prototypes

ROOT = Path(__file__).resolve().parents[4]

FITTED = {"area_share", "heights", "leaf_appearance", "lit", "lit_bare", "overlap", "sides", "tone"}
"""Names under which fitted values stood in files, and under which fits have them now."""

KINDS = {
    "bench/count/workloads.json",
    "bench/studies/appearance/kinds/*.toml",
    "scenes/models/animals/*.toml",
    "scenes/models/people/*.toml",
    "scenes/models/trees/species/*.toml",
    "scenes/presets/*.toml",
    "scenes/sticks/appearance/sky.csv",
}


def data_files() -> list[Path]:
    listed = ["git", "ls-files", "-z", "lod", "scenes", "bench"]
    said = subprocess.run(listed, cwd=ROOT, capture_output=True, check=True).stdout.decode()
    found = [Path(name) for name in said.split("\0") if name]
    return [each for each in found if each.suffix in (".toml", ".csv", ".json", ".npz", ".npy")]


def keys_of(values: object) -> set[str]:
    if isinstance(values, dict):
        return set(values).union(*map(keys_of, values.values()))
    return set().union(*map(keys_of, values)) if isinstance(values, list) else set()


def test_data_files_are_of_known_kinds_and_have_nothing_fitted() -> None:
    files = data_files()
    assert len(files) > 20
    for path in files:
        assert any(path.match(kind) for kind in KINDS), f"{path}: of which kind is it?"
        if path.suffix == ".toml":
            found = keys_of(tomllib.loads((ROOT / path).read_text(encoding="utf-8")))
            assert not found & FITTED, path


def test_a_fit_does_not_know_the_name_of_its_species() -> None:
    species = tree_species("dead_tree")
    (named,), (nameless,) = (
        tree_prototypes(6, 1, each) for each in (species, replace(species, name="none of yours"))
    )
    for name in ("first", "start", "end", "start_radius", "end_radius", "tint"):
        assert np.array_equal(getattr(named.leaf, name), getattr(nameless.leaf, name)), name
    views = named.view_dependence, nameless.view_dependence
    assert np.array_equal(*(each.area_share for each in views)) and len(views[0].area_share)
    assert np.array_equal(named.hierarchy.overlap, nameless.hierarchy.overlap)
    assert np.array_equal(named.hierarchy.P, nameless.hierarchy.P)
