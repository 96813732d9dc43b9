"""A sequence on a cluster through the program: what it delivers, names and repairs."""

import json
import os
import sys
from functools import partial
from pathlib import Path

import cloudpickle
import numpy as np
import pytest

from bench.cli.main import main
from scenes.files import partial_path
from scenes.render import cluster as cluster_frames
from scenes.render.cluster import frame_task
from scenes.render.exr.sequence import read_whole

pytest.importorskip("distributed")
cloudpickle.register_pickle_by_value(sys.modules[__name__])
pytestmark = pytest.mark.slow

FLAGS = "--size", "8x4", "--spp", "1", "--detail", "64", "--variant", "scalar_rgb"


def lodbench(capfd, *arguments):
    with pytest.raises(SystemExit) as left:
        main([*arguments, "--cluster", "2", "--json"])
    out, err = capfd.readouterr()
    return left.value.code, [json.loads(line) for line in out.splitlines()], err


def poisonous(settings, frame, path, threads, most_bytes):
    """Frame 7 ends its worker; each try leaves a mark."""
    with (Path(path).parent.parent / "tries").open("a") as file:
        file.write(f"{frame}\n")
    if frame == 7:
        os._exit(1)
    from scenes.frame.layers import Layers
    from scenes.render.exr.layer_file import write_exr

    ids, colour = np.full((4, 8), frame), np.full((4, 8, 3), frame / 100)
    partial_ = partial_path(Path(path))
    digest = write_exr(partial_, Layers(colour, ids, colour, colour, ids, ids, ids), {})
    record = {"frame": frame, "sha256": digest, "seconds": {}, "statistics": {}}
    return {"record": {**record, "peak_rss_bytes": 1}, "partial": str(partial_)}


def test_one_poisonous_frame_in_twenty_costs_that_frame(tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    poisoned = partial(cluster_frames.render_on_cluster, task=poisonous)
    monkeypatch.setattr(cluster_frames, "render_on_cluster", poisoned)
    words = "render", "meadow", "-o", "out/a.####.exr", "--frames", "1-20", *FLAGS
    code, (*lines, end), err = lodbench(capfd, *words)
    assert code == 1
    assert sorted(line["frame"] for line in lines) == [n for n in range(1, 21) if n != 7]
    (failure,) = end["failures"]
    assert (end["done"], end["failed"], failure["frame"], failure["tries"]) == (19, 1, 7, 3)
    assert "1 of 20 frames failed: frame 7: it ended its worker 3 times" in err
    assert (tmp_path / "tries").read_text().split().count("7") == 3


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
