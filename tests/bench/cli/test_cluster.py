"""A sequence on a cluster through the program: what it delivers, names and repairs."""

import json
import sys
from pathlib import Path

import cloudpickle
import pytest

from bench.cli.main import main
from scenes.render import cluster as cluster_frames
from scenes.render.cluster import frame_task
from scenes.render.exr.frames_on_disk import read_whole

pytest.importorskip("distributed")
cloudpickle.register_pickle_by_value(sys.modules[__name__])
pytestmark = pytest.mark.slow

FLAGS = "--size", "8x4", "--spp", "1", "--detail", "64", "--variant", "scalar_rgb"


def lodbench(capfd, *arguments):
    with pytest.raises(SystemExit) as left:
        main([*arguments, "--cluster", "2", "--json"])
    out, err = capfd.readouterr()
    return left.value.code, [json.loads(line) for line in out.splitlines()], err


def test_what_is_damaged_is_repaired_on_the_cluster(tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    words = "render", "meadow", "-o", "out/a.####.exr", "--frames", "1-4", *FLAGS
    code, (*lines, _), _ = lodbench(capfd, *words)
    assert code == 0
    Path("out/a.0002.exr").write_bytes(b"")
    Path("out/a.0003.exr").unlink()
    asked = []

    def seen(job, workers):
        asked.extend(job.paths)
        return render_on_cluster(job, workers, frame_task)

    render_on_cluster = cluster_frames.render_on_cluster
    monkeypatch.setattr(cluster_frames, "render_on_cluster", seen)
    code, (*_, counts), _ = lodbench(capfd, "verify", "out", "--repair")
    assert (code, counts) == (0, {"frames": 4, "wrong": 2, "repaired": 2})
    assert asked == [2, 3]
    for line in lines:
        assert read_whole(line["path"]).sha256 == line["sha256"]


def test_workers_that_have_nothing_to_repair_are_refused(tmp_path, capfd):
    code, lines, err = lodbench(capfd, "verify", str(tmp_path))
    assert (code, lines) == (2, [])
    assert "--cluster: 'alone': workers only repair" in err and err.count("\n") == 1
