"""A species of tree is one TOML file, and what is wrong in it is said."""

import shutil
from pathlib import Path

import pytest

from lod.errors import InputError
from scenes.models.trees.species_files import read_species, species_folder, tree_species
from scenes.models.trees.tree import tree_prototypes

FOLDER = Path(str(species_folder()))


@pytest.fixture
def willow(tmp_path):
    """The file of a species of one's own, and a way to read it with some text replaced."""
    shutil.copy(FOLDER / "birch.toml", tmp_path / "willow.toml")

    def read(old="", new=""):
        path = tmp_path / "willow.toml"
        text = path.read_text()
        assert old in text
        path.write_text(text.replace(old, new, 1))
        return read_species(path)

    return read


def test_a_copy_is_the_same_species_under_another_name(willow):
    ours, theirs = willow(), tree_species("birch")
    assert ours.name == "willow"
    assert (ours.levels, ours.foliage) == (theirs.levels, theirs.foliage)


def test_a_parameter_changes_the_tree(willow):
    it = willow("attraction_up = -1.0 ", "attraction_up = -2.0 ")
    lows = [
        tree_prototypes(1, 1, each)[0].leaf.start[:, 2].mean()
        for each in (tree_species("birch"), it)
    ]
    assert lows[1] < lows[0]


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
        ("summer = {", "monsoon = {", r"foliage.albedo.monsoon.*spring"),
    ],
)
def test_errors_name_the_file_the_key_what_arrived_and_the_rule(willow, old, new, message):
    with pytest.raises(InputError, match=message):
        willow(old, new)
