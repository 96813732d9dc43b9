"""A sequence on a cluster: the same frames, whatever dies on the way."""

import contextlib
import os
import signal
import socket
import subprocess
import sys
import threading
import time

import cloudpickle
import numpy as np
import pytest

from lod.errors import InputError
from scenes.files import partial_path
from scenes.frame.layers import Layers
from scenes.presets.load import load_preset
from scenes.render import cluster as dask_cluster
from scenes.render.cluster import (
    Cluster,
    cluster,
    render_on_cluster,
    sweep,
)
from scenes.render.exr.frames_on_disk import open_job, render_sequence
from scenes.render.exr.header import frame_settings
from scenes.render.exr.layer_file import write_exr
from scenes.render.frame_session import FrameSession

pytest.importorskip("distributed")
cloudpickle.register_pickle_by_value(sys.modules[__name__])

TINY = """
[camera]
speed = 20
[terrain]
reach = 100
[species.figure]
model = "figure"
density = 0.01
[render]
size = "16x9"
spp = 1
variant = "scalar_rgb"
"""


@pytest.fixture(scope="module")
def settings(tmp_path_factory):
    path = tmp_path_factory.mktemp("preset") / "tiny.toml"
    path.write_text(TINY)
    return frame_settings(load_preset(str(path)), "scalar_rgb")


@pytest.fixture(scope="module")
def two():
    with cluster("2", 1) as workers:
        yield workers


def hashes(records):
    return {record["frame"]: record["sha256"] for record in records}


def test_a_worker_that_dies_on_the_way_changes_nothing(settings, two, tmp_path):
    """Local against two workers, one of which is killed as soon as a frame is there."""
    frames = range(1, 9)
    here = open_job(tmp_path / "l" / "a.####.exr", frames, settings)
    session = FrameSession(settings)
    local = list(render_sequence(here, lambda _, frame, path: session.render(frame, path)))
    job = open_job(tmp_path / "d" / "a.####.exr", frames, settings)
    workers, records = two.client.run(os.getpid), []
    for record in render_on_cluster(job, two):
        if not records:
            os.kill(min(workers.values()), signal.SIGKILL)
        records.append(record)
    sweep(job)
    assert hashes(records) == hashes(local)
    assert len(records) == 8 and not any("error" in record for record in records)
    names = sorted(path.name for path in (tmp_path / "d").iterdir())
    assert names == [f"a.{frame:04d}.exr" for frame in frames]
    again = list(render_on_cluster(open_job(job.folder / "a.####.exr", frames, settings), two))
    assert all(record["kept"] for record in again) and hashes(again) == hashes(local)


def test_workers_of_this_machine_take_tasks_from_this_process_alone(two):
    """Another process of the machine finds no port but the loopback's, and no way in."""
    from urllib.error import HTTPError
    from urllib.request import urlopen

    from distributed import Client
    from psutil import Process

    processes = [Process(), *Process().children(recursive=True)]
    listening = [c.laddr for p in processes for c in p.net_connections() if c.status == "LISTEN"]
    assert len(listening) >= 3 and {each.ip for each in listening} == {"127.0.0.1"}
    for scheme in ("tcp", "tls"):
        with pytest.raises((OSError, TypeError)):
            address = two.client.scheduler.address.replace("tls", scheme)
            Client(address, timeout=1).close()
    dashboard = two.client.cluster.scheduler.http_server.port
    with pytest.raises(HTTPError, match="404"):
        urlopen(f"http://127.0.0.1:{dashboard}/status", timeout=5)


def poisonous(settings, frame, path, threads, most_bytes):
    """Frame 7 ends its worker, frame 9 fails, the others are quick; each try leaves a mark."""
    from pathlib import Path

    mark = Path(path).parent.parent / "tries"
    with mark.open("a") as file:
        file.write(f"{frame}\n")
    if frame == 7:
        os._exit(1)
    if frame == 9:
        raise RuntimeError("no such luck")
    ids = np.full((2, 3), frame)
    colour = np.full((2, 3, 3), frame / 100)
    partial = partial_path(Path(path))
    digest = write_exr(partial, Layers(colour, ids, colour, colour, ids, ids, ids), {})
    record = {"frame": frame, "sha256": digest, "seconds": {}, "statistics": {}}
    return {"record": {**record, "peak_rss_bytes": 1}, "partial": str(partial)}


def test_a_poisonous_frame_costs_itself_only(settings, two, tmp_path):
    """One in 20 always kills its worker and one always fails: 18 delivered, both named, each
    tried three times at most."""
    job = open_job(tmp_path / "d" / "a.####.exr", range(1, 21), settings)
    records = {record["frame"]: record for record in render_on_cluster(job, two, poisonous)}
    bad = {frame: record for frame, record in records.items() if "error" in record}
    tries = (tmp_path / "tries").read_text().split()
    assert sorted(records) == list(range(1, 21)) and sorted(bad) == [7, 9]
    assert bad[7]["tries"] == 3 == tries.count("7") and "ended its worker" in bad[7]["error"]
    assert bad[9]["tries"] == 3 == tries.count("9") and "no such luck" in bad[9]["error"]
    assert {path.name for path in job.folder.glob("*.exr")} == {
        f"a.{frame:04d}.exr" for frame in range(1, 21) if frame not in bad
    }


def test_a_worker_with_another_version_is_refused(settings, two, tmp_path):
    other = {**settings, "software": "lodbench 0.0 (Mitsuba 3.0)"}
    job = open_job(tmp_path / "a.####.exr", [1], other)
    with pytest.raises(InputError, match=r"lodbench 0\.0 .*install the same versions"):
        list(render_on_cluster(job, two))


def test_a_cluster_that_lost_all_workers_is_not_waited_for_without_end(
    settings, tmp_path, monkeypatch
):
    monkeypatch.setattr(dask_cluster, "_WORKERS_S", 1)
    job = open_job(tmp_path / "a.####.exr", [1], settings)
    with cluster("1", 1) as one:
        one.client.cluster.scale(0)
        with pytest.raises(InputError, match="no worker is left"):
            list(render_on_cluster(job, one))


@pytest.mark.parametrize("where", ["0", "9999", "nowhere", "tcp://"])
def test_what_is_no_cluster_is_refused(where):
    with pytest.raises(InputError, match="--cluster"), cluster(where):
        pass


def test_without_dask_the_extra_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(InputError, match=r"lodbench\[cluster\]"), cluster("2"):
        pass


def test_a_frame_that_cannot_be_is_bad_input_if_nothing_was_done(settings, two, tmp_path):
    wrong = {**settings, "camera": {**settings["camera"], "fov": 500.0}}
    job = open_job(tmp_path / "a.####.exr", [1, 2], wrong)
    with pytest.raises(InputError, match="fov"):
        list(render_on_cluster(job, Cluster(two.client, 1)))


@pytest.mark.parametrize("banner", [b"HTTP/1.1 400 Bad Request\r\n\r\n", bytes(64), b"", None])
def test_a_port_that_is_not_of_dask_is_named(monkeypatch, banner):
    monkeypatch.setattr(dask_cluster, "_ANSWER_S", 1)
    with socket.create_server(("127.0.0.1", 0)) as server, contextlib.ExitStack() as stack:

        def answer():
            with contextlib.suppress(OSError):
                while True:
                    connection = server.accept()[0]
                    connection.sendall(banner or b"")
                    if banner is None:
                        stack.callback(connection.close)
                    else:
                        connection.close()

        stack.callback(server.shutdown, socket.SHUT_RDWR)
        threading.Thread(target=answer, daemon=True).start()
        where = f"tcp://127.0.0.1:{server.getsockname()[1]}"
        rule = f"--cluster: '{where}': a Dask scheduler's address; connecting ended with: ."
        with pytest.raises(InputError, match=rule), cluster(where):
            pass


def test_a_port_where_nothing_listens_and_a_file_that_names_none(monkeypatch, tmp_path):
    monkeypatch.setattr(dask_cluster, "_ANSWER_S", 1)
    with socket.create_server(("127.0.0.1", 0)) as server:
        free = server.getsockname()[1]
    with (
        pytest.raises(InputError, match="connecting ended with"),
        cluster(f"tcp://127.0.0.1:{free}"),
    ):
        pass
    for text in ("", "{", "[]", '{"address"', '{"id": 1}'):
        (tmp_path / "scheduler.json").write_text(text)
        with (
            pytest.raises(InputError, match="file that a Dask scheduler wrote"),
            cluster(str(tmp_path / "scheduler.json")),
        ):
            pass


def test_a_scheduler_without_workers_is_said_and_refused_in_time(monkeypatch):
    from distributed import LocalCluster

    monkeypatch.setattr(dask_cluster, "_WORKERS_S", 0.5)
    said = []
    with LocalCluster(n_workers=0, dashboard_address=":0", silence_logs=50) as empty:
        address = empty.scheduler_address
        with pytest.raises(InputError, match=r"with workers; none came in 0.5 s; start one: dask"):
            with cluster(address, say=said.append):
                pass
    assert f"{address} has no worker yet: waiting for one, 0.5 s at most" in said[-1]


def test_a_worker_that_comes_late_is_waited_for():
    from distributed import LocalCluster

    said = []
    with LocalCluster(n_workers=0, dashboard_address=":0", silence_logs=50) as growing:
        growing.adapt(minimum=0, maximum=1, interval="50ms")  # none without a task to do
        with cluster(growing.scheduler_address, say=said.append) as workers:
            assert len(workers.client.scheduler_info()["workers"]) == 1
    assert "has no worker yet" in said[-1]


def slow(settings, frame, path, threads, most_bytes):
    import time

    time.sleep(60)


def test_a_scheduler_that_is_killed_is_said_in_one_line(settings, tmp_path, capfd):
    words = sys.executable, "-m", "distributed.cli.dask_scheduler", "--port", "0"
    file = tmp_path / "scheduler.json"
    scheduler = subprocess.Popen(
        [*words, "--no-dashboard", "--scheduler-file", str(file)], stderr=subprocess.DEVNULL
    )
    while not file.exists():
        assert scheduler.poll() is None
        time.sleep(0.1)
    words = sys.executable, "-m", "distributed.cli.dask_worker", "--no-dashboard"
    worker = subprocess.Popen(
        [*words, "--scheduler-file", str(file), "--no-nanny"], stderr=subprocess.DEVNULL
    )
    try:
        job = open_job(tmp_path / "a.####.exr", [1, 2], settings)
        with pytest.raises(ConnectionError, match="the scheduler has gone"):
            with cluster(str(file)) as workers:
                threading.Timer(1.0, scheduler.kill).start()
                list(render_on_cluster(job, workers, slow))
    finally:
        for process in (worker, scheduler):
            process.kill()
            process.wait()
    assert "Traceback" not in capfd.readouterr().err
