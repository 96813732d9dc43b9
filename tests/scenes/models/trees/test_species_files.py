"""A species of tree is one TOML file and one CSV file, and what is wrong in them is said."""

import shutil
from pathlib import Path

import pytest

from lod.errors import InputError
from scenes.model_files.names import tree_species_names
from scenes.models.trees.appearance_tables import AppearanceTables, read_tables, table_text
from scenes.models.trees.species_files import read_species, species_folder, tree_species
from scenes.models.trees.tree import tree_prototypes

FOLDER = Path(str(species_folder()))


@pytest.fixture
def willow(tmp_path):
    """Files of a species of one's own, and a way to read them with some text replaced."""
    for kind in ("toml", "csv"):
        shutil.copy(FOLDER / f"birch.{kind}", tmp_path / f"willow.{kind}")

    def read(old="", new="", kind="toml"):
        path = tmp_path / f"willow.{kind}"
        text = path.read_text()
        assert old in text
        path.write_text(text.replace(old, new, 1))
        return read_species(tmp_path / "willow.toml", tmp_path / "willow.csv")

    return read


def test_a_copy_is_the_same_species_under_another_name(willow):
    ours, theirs = willow(), tree_species("birch")
    assert ours.name == "willow"
    assert (ours.levels, ours.foliage, ours.tables) == (
        theirs.levels,
        theirs.foliage,
        theirs.tables,
    )


def test_a_parameter_changes_the_tree(willow):
    it = willow("attraction_up = -1.0 ", "attraction_up = -2.0 ")
    lows = [
        tree_prototypes(1, 1, each)[0].leaf.start[:, 2].mean()
        for each in (tree_species("birch"), it)
    ]
    assert lows[1] < lows[0]


@pytest.mark.parametrize("name", tree_species_names())
def test_tables_are_written_as_they_are_read(name):
    path = FOLDER / f"{name}.csv"
    assert table_text(read_tables(path)) == path.read_text()


def test_a_species_without_tables_is_uncorrected(willow, tmp_path):
    (tmp_path / "willow.csv").unlink()
    it = willow()
    assert it.tables == it.bare_tables == AppearanceTables()
    for season in ("summer", "winter"):
        (tree,) = tree_prototypes(1, 1, it, season)
        assert not tree.hierarchy.overlap.any()


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("scale = 11.0", "scale = -11.0", r"willow.toml: scale: -11.0: greater than 0"),
        ("scale = 11.0", 'scale = "tall"', r"willow.toml: scale: 'tall': a valid number"),
        ("scale = 11.0", "scale = inf", r"willow.toml: scale: .*finite"),
        ("scale = 11.0", "scail = 11.0", r"willow.toml: scail: 11.0: no such key"),
        ("scale_v = 1.0", "", r"willow.toml: scale_v: 'missing': a required key"),
        ("curve_res = 4", "curve_res = 4.5", r"levels\[0\].curve_res: 4.5: "),
        ("scale = 11.0", "scale = ", r"willow.toml: .*a TOML file"),
        ("scale = 11.0", 'name = "oak"\nscale = 11.0', r"willow.toml: name: 'oak': no such key"),
        (
            "blob_count = [4, ",
            "blob_count = [",
            r"leaf_appearance.blob_count: 3: 4 entries",
        ),
        ("summer = {", "monsoon = {", r"foliage.albedo.monsoon.*spring"),
    ],
)
def test_errors_name_the_file_the_key_what_arrived_and_the_rule(willow, old, new, message):
    with pytest.raises(InputError, match=message):
        willow(old, new)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (
            "foliage,quantity",
            "quantity,foliage",
            r"willow.csv: .*its first line is foliage,quantity",
        ),
        ("leaf,overlap,1,,0.32\n", "", r"willow.csv: leaf, overlap, level 1: 'missing'"),
        (
            "leaf,overlap,3,,0.45\n",
            "",
            r"willow.csv: overlap: '3 levels': no level or each",
        ),
        ("leaf,overlap,1,,0.32", "leaf,overlap,1,,x", r"willow.csv: line 43: .*numbers"),
        ("leaf,overlap,1,", "leaf,overlap,1,30", r"line 43: '30': an angle of overlap: none"),
        ("leaf,overlap,1,", "leaf,overlaps,1,", r"line 43: 'overlaps': one of albedo_factor"),
    ],
)
def test_errors_of_tables_name_the_line_and_the_cure(willow, old, new, message):
    with pytest.raises(InputError, match=message):
        willow(old, new, "csv")
