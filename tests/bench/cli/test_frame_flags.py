"""Which frames, and where they go."""

from pathlib import Path

import pytest

from bench.cli.flags import frame_numbers, memory_limit_bytes
from lod.errors import InputError
from scenes.files import check_pattern, frame_path, make_folder


@pytest.mark.parametrize(
    ("text", "frames"),
    [
        ("1", (1,)),
        ("1-4", (1, 2, 3, 4)),
        ("9, 1,5", (1, 5, 9)),
        ("1-3,2-5", (1, 2, 3, 4, 5)),
        ("7-7", (7,)),
        ("1-40x10", (1, 11, 21, 31)),
        ("3-9x3, 4", (3, 4, 6, 9)),
    ],
)
def test_frames_are_numbers_each_once(text: str, frames: tuple[int, ...]) -> None:
    assert frame_numbers(text) == frames


@pytest.mark.parametrize(
    "text",
    ["", "a", "1-", "-1", "1..3", "3-1", "0-2", "1;2", "1 2", "1234567", "1-9x0", "1-9x", "5x2"],
)
def test_what_are_no_frames_is_refused(text: str) -> None:
    with pytest.raises(InputError, match="--frames"):
        frame_numbers(text)


def test_a_pattern_becomes_a_path() -> None:
    assert frame_path("out/a.####.exr", 7) == Path("out/a.0007.exr")
    assert frame_path("####.exr", 12345) == Path("12345.exr")


@pytest.mark.parametrize(
    "text",
    [
        "a.exr",
        "a.###.exr",
        "a.#####.exr",
        "a.####.####.exr",
        "####/a.exr",
        "##/a.####.exr",
        "a.####.EXR",
        "",
    ],
)
def test_what_is_no_pattern_is_refused(text: str) -> None:
    with pytest.raises(InputError, match=r"-o"):
        check_pattern(text)


def test_a_folder_is_made_with_its_parents(tmp_path: Path) -> None:
    assert make_folder(tmp_path / "a" / "b").is_dir()
    assert list((tmp_path / "a" / "b").iterdir()) == []


def test_a_folder_that_cannot_be_made_leaves_nothing(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="-o"):
        make_folder(tmp_path / "a" / ("n" * 300))
    assert list(tmp_path.iterdir()) == []


def test_memory_sizes():
    assert memory_limit_bytes("4GB") == 4_000_000_000 and memory_limit_bytes("1.5 gib") == 3 * 2**29
    for text in ("4", "GB", "0GB", "-1GB", "4TB", "nanGB", ""):
        with pytest.raises(InputError, match="--max-memory"):
            memory_limit_bytes(text)
