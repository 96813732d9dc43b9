"""What is free is the least that the machine and every group around the process leave."""

from pathlib import Path

import psutil
import pytest

from scenes.render.memory import free_bytes

GIB = 2**30


@pytest.fixture
def machine(monkeypatch: pytest.MonkeyPatch) -> None:
    class Memory:
        available = 64 * GIB

    monkeypatch.setattr(psutil, "virtual_memory", Memory)


def own(folder: Path, line: str) -> Path:
    (folder / "own").write_text(line)
    return folder / "own"


def group(folder: Path, limit: str, used: int, cached: int, version: int = 2) -> None:
    names = ("memory.max", "memory.current", "inactive_file")
    if version == 1:
        names = ("memory.limit_in_bytes", "memory.usage_in_bytes", "total_inactive_file")
    folder.mkdir(parents=True, exist_ok=True)
    (folder / names[0]).write_text(f"{limit}\n")
    (folder / names[1]).write_text(f"{used}\n")
    (folder / "memory.stat").write_text(f"anon 7\n{names[2]} {cached}\n")


@pytest.mark.usefixtures("machine")
@pytest.mark.parametrize("version", [1, 2])
def test_a_container_s_limit_counts_and_file_caches_are_free(tmp_path: Path, version: int) -> None:
    root = tmp_path / "cgroups"
    line = "0::/\n" if version == 2 else "5:cpu:/\n4:memory:/\n"
    group(root if version == 2 else root / "memory", str(4 * GIB), 3 * GIB, GIB, version)
    assert free_bytes(root, own(tmp_path, line)) == 2 * GIB


@pytest.mark.usefixtures("machine")
def test_the_tightest_of_nested_groups_counts(tmp_path: Path) -> None:
    root = tmp_path / "cgroups"
    group(root / "job", str(8 * GIB), 6 * GIB, 0)
    group(root / "job" / "step", "max", GIB, 0)
    assert free_bytes(root, own(tmp_path, "0::/job/step\n")) == 2 * GIB


@pytest.mark.usefixtures("machine")
def test_a_path_of_the_host_s_leads_to_the_root_that_is_mounted(tmp_path: Path) -> None:
    root = tmp_path / "cgroups"
    group(root, str(GIB), 0, 0)
    assert free_bytes(root, own(tmp_path, "0::/docker/0123abc\n")) == GIB


@pytest.mark.usefixtures("machine")
def test_without_groups_the_machine_counts(tmp_path: Path) -> None:
    assert free_bytes(tmp_path / "none", tmp_path / "none") == 64 * GIB


@pytest.mark.usefixtures("machine")
def test_what_is_over_a_limit_leaves_nothing(tmp_path: Path) -> None:
    group(tmp_path / "cgroups", str(GIB), 2 * GIB, 0)
    assert free_bytes(tmp_path / "cgroups", own(tmp_path, "0::/\n")) == 0
