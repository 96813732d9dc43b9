"""A file is whole or not there, and nothing that others wrote is ever replaced unasked."""

import errno
import os

import pytest

from lod.errors import InputError
from scenes.files import check_free, made_by_lodbench, whole_file


def test_it_gets_its_name_when_it_is_whole(tmp_path):
    path = tmp_path / "a.usdc"
    with whole_file(path) as temporary:
        assert temporary.parent == tmp_path and temporary.suffix == ".usdc"
        temporary.write_text("whole")
        assert not path.exists()
    assert os.listdir(tmp_path) == ["a.usdc"] and path.read_text() == "whole"


@pytest.mark.parametrize("error", [KeyboardInterrupt(), OSError(errno.ENOSPC, "full")])
def test_what_ends_on_the_way_leaves_nothing(tmp_path, error):
    (tmp_path / "a.png").write_text("before")
    with pytest.raises(type(error)), whole_file(tmp_path / "a.png", overwrite=True) as temporary:
        temporary.write_text("half")
        raise error
    assert os.listdir(tmp_path) == ["a.png"] and (tmp_path / "a.png").read_text() == "before"


@pytest.mark.parametrize("links", [True, False])
def test_what_stands_or_comes_meanwhile_stays(tmp_path, monkeypatch, links):
    def refused(*_):
        raise OSError(errno.EPERM, "no links here")

    if not links:
        monkeypatch.setattr(os, "link", refused)
    path = tmp_path / "a.usda"
    path.symlink_to("nowhere")
    with pytest.raises(InputError, match="not there yet; choose another name, or --overwrite"):
        check_free(path)
    path.unlink()
    with pytest.raises(InputError, match="--overwrite"), whole_file(path) as temporary:
        temporary.write_text("ours")
        path.write_text("theirs")
    assert os.listdir(tmp_path) == ["a.usda"] and path.read_text() == "theirs"
    with whole_file(path, overwrite=True) as temporary:
        temporary.write_text("ours")
    assert path.read_text() == "ours"
    with whole_file(tmp_path / "new") as temporary:
        temporary.write_text("ours")
    assert sorted(os.listdir(tmp_path)) == ["a.usda", "new"]


def test_a_folder_is_never_replaced(tmp_path):
    with pytest.raises(InputError, match="a folder is there"):
        check_free(tmp_path, overwrite=True)


@pytest.mark.parametrize("before", [0, 100_000])
def test_what_is_ours_says_so(tmp_path, before):
    path = tmp_path / "a"
    assert not made_by_lodbench(path)
    path.write_bytes(bytes(before) + b"by lodbench 1.0" + bytes(before // 4))
    assert made_by_lodbench(path)
    path.write_bytes(bytes(2 * before + 9))
    assert not made_by_lodbench(path)
