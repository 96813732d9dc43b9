"""The process that renders: what it says, what its death costs, and that it never stays.

The process that starts it never loads the renderer or the scene.
"""

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

from lod.errors import InputError
from scenes.render import worker as worker_module
from scenes.render.exr.frames_on_disk import FrameFailed, open_job
from scenes.render.worker import MOST_TRIES, Worker, render_left

SETTINGS = {"render": {"variant": "scalar_rgb"}}

CHILD = '''
"""Renders nothing, and does what the number of a frame says."""

import os
import signal
import time
from pathlib import Path

from lod.errors import InputError
from scenes.processes.progress import tell, work
from scenes.render.worker import serve


class Session:
    opened = 0

    def __init__(self, settings):
        if settings["render"].get("spp") == 0:
            raise InputError("render.spp", 0, "1 or more", "try 16")
        self.settings = settings
        Session.opened += 1

    def preflight(self, frames, folder, most_bytes):
        (Path(folder) / "estimated").write_text(f"{frames} {most_bytes}")
        if 105 in frames:
            raise InputError("--max-memory", "1 GB", "frame 105 needs more", "ask for less")
        if 107 in frames:
            os.kill(os.getpid(), signal.SIGKILL)
        return {}

    def render(self, frame, target, watch, most_bytes):
        with Path(target).with_name("tries").open("a") as file:
            file.write(f"{frame} {os.getpid()} {os.environ['LODBENCH_TRUSTED_VARIANT']}\\n")
        if frame == 7:
            Path(target).write_text("half")
            os.kill(os.getpid(), signal.SIGKILL)
        if frame == 101:
            raise InputError("camera.height", -1.5, "above 0", "try 2")
        if frame == 102:
            raise OSError(28, "No space left on device", target)
        if frame == 103:
            raise ZeroDivisionError("of  all\\nthings")
        if frame == 104:
            time.sleep(1000)
        print("a library's chatter")
        if frame == 108:
            with work("fitting things", 2):
                tell()
                tell(1.5)
        watch(1, 2)
        watch(2, 2)
        Path(target).write_text(f"frame {frame}")
        statistics = {"opened": Session.opened, "seed": self.settings.get("seed", 0)}
        return {"frame": frame, "sha256": "0" * 64, "seconds": {}, "statistics": statistics}


serve(Session)
'''


@pytest.fixture(autouse=True)
def stand_in(tmp_path, monkeypatch):
    path = tmp_path / "child.py"
    path.write_text(CHILD)
    monkeypatch.setattr(worker_module, "CHILD", (sys.executable, "-P", str(path)))


def tries(folder):
    lines = [line.split() for line in (folder / "tries").read_text().splitlines()]
    return [(int(frame), int(process)) for frame, process, _ in lines]


def gone(process):
    """Whether it has ended; a zombie that nobody collects has."""
    try:
        return Path(f"/proc/{process}/stat").read_text().split(") ")[1].startswith("Z")
    except FileNotFoundError:
        return True


def test_one_process_renders_frame_after_frame(tmp_path, capfd):
    seen = []
    with Worker(watch=lambda *each: seen.append(each)) as worker:
        for frame in (1, 2, 3):
            record = worker(SETTINGS, frame, tmp_path / f"{frame}")
            assert record["frame"] == frame
            assert (tmp_path / f"{frame}").read_text() == f"frame {frame}"
    (process,) = {process for _, process in tries(tmp_path)}
    assert process != os.getpid() and gone(process)
    samples = [(process, 1, 2, None), (process, 2, 2, None)]
    assert [each for each in seen if each[2]] == samples * 3
    assert capfd.readouterr().out == ""


def test_what_is_made_before_a_frame_is_told_until_it_is_done(tmp_path):
    seen = []
    with Worker(watch=lambda *each: seen.append(each)) as worker:
        worker(SETTINGS, 108, tmp_path / "108")
    told = [each[1:] for each in seen if each[3] or each[2]]
    made = [(0, 0, ["fitting things", done, 2]) for done in (0.0, 1.5)]
    assert [(a, b, list(c) if c else c) for a, b, c in told] == [*made, (1, 2, None), (2, 2, None)]


def test_a_frame_that_kills_it_is_tried_three_times_and_costs_itself(tmp_path):
    with Worker() as worker:
        worker(SETTINGS, 6, tmp_path / "6")
        with pytest.raises(FrameFailed, match=r"3 times \(SIGKILL") as failed:
            worker(SETTINGS, 7, tmp_path / "7")
        worker(SETTINGS, 8, tmp_path / "8")
    assert failed.value.tries == MOST_TRIES == 3
    assert [frame for frame, _ in tries(tmp_path)] == [6, 7, 7, 7, 8]
    assert not (tmp_path / "7").exists()
    assert all(gone(process) for _, process in tries(tmp_path))


def test_errors_come_through_and_the_process_stays(tmp_path):
    with Worker() as worker:
        with pytest.raises(InputError, match=r"^camera\.height: -1\.5: above 0; try 2$"):
            worker(SETTINGS, 101, tmp_path / "a")
        with pytest.raises(OSError, match="No space left") as refused:
            worker(SETTINGS, 102, tmp_path / "a")
        with pytest.raises(FrameFailed, match=r"^ZeroDivisionError: of all things$") as failed:
            worker(SETTINGS, 103, tmp_path / "a")
    assert refused.value.errno == 28 and failed.value.tries == 1
    assert len({process for _, process in tries(tmp_path)}) == 1


def test_a_session_lasts_until_other_settings_come(tmp_path):
    with Worker() as worker:
        found = [
            worker({**SETTINGS, "seed": seed}, frame, tmp_path / f"{frame}")["statistics"]
            for frame, seed in enumerate((3, 3, 5, 5, 3), 1)
        ]
        assert [each["seed"] for each in found] == [3, 3, 5, 5, 3]
        assert [each["opened"] for each in found] == [1, 1, 2, 2, 3]
        wrong = {"render": {"variant": "scalar_rgb", "spp": 0}}
        for _ in range(2):
            with pytest.raises(InputError, match=r"^render\.spp: 0"):
                worker(wrong, 6, tmp_path / "6")
        assert worker(SETTINGS, 7 + 1, tmp_path / "8")["statistics"]["seed"] == 0
    assert len({process for _, process in tries(tmp_path)}) == 1


def test_a_sequence_is_estimated_before_its_first_frame(tmp_path):
    job = open_job(tmp_path / "a.####.exr", (1, 2, 105), SETTINGS)
    with Worker(most_bytes=10**9) as worker, pytest.raises(InputError, match="frame 105"):
        list(render_left(job, worker))
    assert not (tmp_path / "tries").exists()
    job = open_job(tmp_path / "b.####.exr", (1, 2, 3), SETTINGS)
    with Worker(most_bytes=10**9) as worker:
        assert [each["frame"] for each in render_left(job, worker)] == [1, 2, 3]
    assert (tmp_path / "estimated").read_text() == "[1, 2, 3] 1000000000"


def test_a_process_that_dies_of_a_forecast_fails_no_other_frame(tmp_path):
    job = open_job(tmp_path / "a.####.exr", (1, 107), SETTINGS)
    with Worker() as worker:
        assert len(list(render_left(job, worker))) == 2
    assert len({process for _, process in tries(tmp_path)}) == 1


def test_an_interrupt_ends_it_at_once(tmp_path):
    def interrupt(*_):
        if (tmp_path / "tries").exists():
            raise KeyboardInterrupt

    start = time.monotonic()
    with pytest.raises(KeyboardInterrupt), Worker(watch=interrupt) as worker:
        worker(SETTINGS, 104, tmp_path / "a")
    assert time.monotonic() - start < 30
    assert all(gone(process) for _, process in tries(tmp_path))


def test_one_that_does_not_start_says_so(tmp_path, monkeypatch):
    monkeypatch.setattr(worker_module, "CHILD", (sys.executable, "-c", "raise SystemExit(3)"))
    with pytest.raises(RuntimeError, match=r"does not start .exit code 3"), Worker() as worker:
        worker(SETTINGS, 1, tmp_path / "a")


HEAVY = ("mitsuba", "drjit", "numba", "OpenEXR", "scipy", "colour")

CODE = f"""
import sys
import bench.cli.commands.render, bench.cli.output
import scenes.render.exr.frames_on_disk, scenes.render.worker
import scenes.render.variants
print(*[name for name in {HEAVY} if name in sys.modules])
"""


def test_what_renders_stays_in_the_child():
    done = subprocess.run(
        [sys.executable, "-c", CODE],
        capture_output=True,
        text=True,
        env={"PYTHONPATH": ":".join(sys.path)},
    )
    assert (done.returncode, done.stdout.strip()) == (0, ""), done.stderr
