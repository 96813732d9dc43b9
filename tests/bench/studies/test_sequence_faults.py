"""What nights do to renderers, a few times each; ``lodbench study sequence_faults`` does more."""

import os
import subprocess
from pathlib import Path

import pytest

from bench.studies.memory import SCENES, memory_growth, predicted_memory, render_scene
from bench.studies.sequence_faults.program_run import Place
from bench.studies.sequence_faults.study import damage, full_disk, interrupts, kills, repeats
from scenes.render.mitsuba.variants import JIT_VARIANT, SCALAR_VARIANT, works

pytestmark = pytest.mark.slow


@pytest.fixture
def place(tmp_path: Path) -> Place:
    return Place(tmp_path, SCALAR_VARIANT)


def test_killed_runs_resume_to_the_same_frames(place: Place) -> None:
    found = kills(place, 3)
    assert found["right after resuming"] == 3
    assert found["partial files under a final name"] == 0


def test_damage_is_found_and_exactly_that_is_rendered_again(place: Place) -> None:
    found = damage(place, 2)
    assert (found["found"], found["found beside"], found["rendered again"]) == (8, 0, 8)
    assert found["exactly those"] and found["hashes as before"]
    assert found["exit codes"] == [1, 0]


def test_threads_processes_and_order_do_not_matter(place: Place) -> None:
    found = repeats(place, 1)
    assert (found["frames"], found["hashes of each frame"]) == (5, [1])


@pytest.mark.parametrize("variant", [SCALAR_VARIANT, JIT_VARIANT])
def test_an_interrupt_ends_it_within_seconds_and_leaves_nothing(
    tmp_path: Path, variant: str
) -> None:
    if (why := works(variant)) is not True:
        pytest.skip(f"{variant} does not work here: {why}")
    found = interrupts(Place(tmp_path, variant), 2)
    assert (found["exit 130"], found["something left behind"]) == (2, 0)
    assert found["longest wait s"] < 5


def test_a_disk_that_is_full_or_read_only_is_named_and_harms_nothing(place: Place) -> None:
    probe = place.folder / "probe"
    probe.mkdir()
    mount = ["mount", "-t", "tmpfs", "tmpfs", str(probe)]
    if os.geteuid() or subprocess.run(mount, capture_output=True).returncode:
        pytest.skip("a disk of its own takes the right to mount one")
    subprocess.run(["umount", str(probe)], check=True)
    found = full_disk(place, 4)
    assert (found["clear errors"], found["finished frames harmed"]) == (4, 0)


@pytest.mark.parametrize("scene", [SCENES[0], SCENES[7]], ids=str)
def test_memory_is_foretold_within_a_quarter(scene: object) -> None:
    if (why := works(scene.variant)) is not True:
        pytest.skip(f"{scene.variant} does not work here: {why}")
    (record,) = render_scene(scene)
    assert 0.75 < predicted_memory(scene, record) / record["peak_rss_bytes"] < 1.25


def test_frame_after_frame_takes_no_more_memory() -> None:
    if works(JIT_VARIANT) is not True:
        pytest.skip("no LLVM here")
    early, late = memory_growth(30)
    assert late < 1.05 * early
