"""Frames of a preset as files: one door for the command line, the Python module and repairs.

A ``FrameSession`` renders them from settings to files, the same way in every process. It works in a
process that can be killed, by Ctrl-C at once or by its own death, and that stays from frame to
frame, so that its world, its compiled kernels and its caches do. The renderer never enters the
process that starts it. ``Worker`` is the one end, ``serve`` the other. What actors do lies beside
the frames, as a pose track that is made once, and from which frames replay.

Requests and answers are JSON objects, one a line. A request is {settings}, which opens a session
with them, {preflight: frames, folder, most_bytes} or {frame, target, most_bytes}. The answers are
{ready} once; an empty {record} of a session that is open, and of frames whose memory is estimated;
and of each frame {samples: [taken, of]} some times, and then its {record}. Before any of them may
come {making: [what, done, steps]} of what is made once and then kept. In place of any record may
come {input: [where, arrived, rule, cure]}, {disk: [errno, strerror, file]} or {failed: text}.
"""

import contextlib
import json
import math
import os
import select
import signal
import subprocess
import sys
import time
import traceback
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from pathlib import Path
from typing import Any

from lod.errors import InputError
from scenes.actors.performance import (
    Performance,
    Track,
    from_bytes,
    performance_of,
    to_bytes,
    track_of,
)
from scenes.files import make_folder, whole_file
from scenes.frame.frame_input import Layers
from scenes.presets.load import has_acting
from scenes.presets.schema import Preset
from scenes.processes.memory_limit import peak_rss_bytes
from scenes.processes.progress import followed_by, kernels_told
from scenes.processes.streams import (
    end_with_parent,
    open_standard_streams,
    own_stdout,
    signals_held,
)
from scenes.render.budget import preflight, within_budget
from scenes.render.description import describe_frame
from scenes.render.exr.header import (
    Record,
    Settings,
    frame_header,
    frame_settings,
    picture_windows,
    preset_from_settings,
    software,
)
from scenes.render.exr.layer_file import with_mattes, write_exr
from scenes.render.exr.sequence import (
    FrameFailed,
    Job,
    open_job,
    owned_folder,
    render_sequence,
    settings_hash,
)
from scenes.render.object_keys import identities_in
from scenes.render.render import render_frame
from scenes.render.variants import choose, trusting
from scenes.scene import Scene, make_terrain
from scenes.world.cast import make_cast

_ACTS = ("seed", "camera", "world", "wind", "terrain", "actors", "troupes", "acting", "script")
"""Tables of a preset on which it depends what actors do, beside the angles that are seen."""


def prepare_track(preset: Preset, folder: str | Path) -> str | None:
    """See that the track of a preset lies in a folder; give its hash, None where nobody acts.

    A whole one is kept; another is made by acting all frames. Raises InputError, in one line, for
    what an actor, a script or a behaviour does that cannot be.
    """
    if not has_acting(preset):
        return None
    path = track_path(preset, make_folder(folder))
    track = read_track(path)
    if track is None:
        track = _acted(preset)
        with whole_file(path, overwrite=True) as partial:
            partial.write_bytes(to_bytes(track))
    return track.digest


def check_acted(preset: Preset, frames: Sequence[int], most_bytes: int | None = None) -> None:
    """Raise InputError for a frame in which the actors of a preset do not act.

    And where all that they do is estimated to need more memory than it may (``preflight``).
    """
    most = preset.acting.frames
    if has_acting(preset) and max(frames) > most:
        rule = f"the actors act in frames 1 to {most}"
        raise InputError("--frames", max(frames), rule, f"add -D acting.frames={max(frames)}")
    preflight(Scene(preset), (), most_bytes, acted=most + 1)


def track_path(preset: Preset, folder: Path) -> Path:
    """Name the track's file by all that it depends on."""
    data = preset.model_dump(mode="json")
    view = {name: data["view"][name] for name in ("offscreen_detail", "look_around")}
    asked: dict[str, Any] = {name: data[name] for name in _ACTS}
    asked |= {"view": view, "size": data["render"]["size"], "software": software()}
    return folder / f"actors-{settings_hash(asked)[:16]}.npz"


def read_track(path: Path) -> Track | None:
    """Read a track; None where none lies there that is whole."""
    try:
        return from_bytes(path.read_bytes())
    except (OSError, ValueError):
        return None


def replayed(preset: Preset, digest: str, folder: Path) -> Performance:
    """Return what the actors of a preset do, by the track of that hash in a folder.

    Where it is not there any more they act again. Raises InputError where that gives another hash.
    """
    track = read_track(track_path(preset, folder))
    if track is None or track.digest != digest:
        track = _acted(preset)
    if track.digest != digest:
        rule = f"a track with the hash {digest[:16]}…, as the frames' settings have it"
        raise InputError("actors", f"{track.digest[:16]}…", rule, "render them anew: --overwrite")
    return performance_of(track)


def _acted(preset: Preset) -> Track:
    return track_of(make_cast(preset, make_terrain(preset)).performance)


Watch = Callable[[int, int], object]
"""Called with the samples of a frame taken so far, and how many there will be."""


def _ignore(*_: object) -> None:
    """Watch nothing."""


class FrameSession:
    """Renders frames of one preset in this process; its world stays from frame to frame.

    settings  of ``frame_settings``, checked here. Raises InputError for what no preset can be
    """

    def __init__(self, settings: Settings) -> None:
        self.settings = settings
        self._preset = preset_from_settings(settings)
        self._folder: Path | None = None
        self._estimated: set[int] = set()

    @cached_property
    def _scene(self) -> Scene:
        track = self.settings.get("track")
        if track is None or self._folder is None:
            return Scene(self._preset)
        return Scene(self._preset, partial(replayed, self._preset, track, self._folder))

    def preflight(
        self, frames: Sequence[int], folder: str | Path | None, most_bytes: int | None = None
    ) -> Record:
        """Estimate the memory of frames whose files will lie in ``folder``; the record is empty.

        Raises InputError for the first that is estimated to need more than ``most_bytes`` allow.
        """
        self._folder = Path(folder) if folder else self._folder
        if new := [each for each in frames if each not in self._estimated]:
            acted = self._preset.acting.frames + 1
            preflight(self._scene, new, most_bytes, self._preset.render.variant, acted)
            self._estimated.update(new)
        return {}

    def render(
        self,
        frame: int,
        target: str | Path,
        watch: Watch = _ignore,
        most_bytes: int | None = None,
    ) -> Record:
        """Render a frame into ``target``, a file that does not exist yet.

        Record: frame, sha256 of the file, seconds {stage: s}, peak_rss_bytes, statistics. Building
        the world counts as the first frame's time. Raises as ``render_layers`` does, and OSError
        where the disk refuses.
        """
        self._folder = Path(target).parent  # where the track of its actors lies
        layers = self.render_layers(frame, watch, most_bytes)
        start = time.perf_counter()
        digest = write_exr(target, layers, self.header(frame), self._preset.output)
        write = time.perf_counter() - start
        return {
            "frame": frame,
            "sha256": digest,
            "seconds": {**layers.seconds, "write": write},
            "peak_rss_bytes": peak_rss_bytes(),
            "statistics": layers.statistics,
        }

    def render_layers(
        self, frame: int, watch: Watch = _ignore, most_bytes: int | None = None
    ) -> Layers:
        """Render a frame into arrays, with the seconds and counts of every stage.

        ``watch`` is called with the samples taken so far, and how many there will be. Raises
        InputError for a frame that cannot be or would need more memory than ``most_bytes`` allow
        (``memory_limit``).
        """
        preset, start = self._preset, time.perf_counter()
        self.preflight((frame,), None, most_bytes)
        scene, world = self._scene, self._scene.world
        seconds = {"world": time.perf_counter() - start}
        frame_input = scene.input(frame, preset.render.variant)
        seconds |= frame_input.seconds
        description, cuts = None, [each.cut for each in frame_input.displayed]
        found = list(identities_in(world, cuts)) if preset.output.cryptomatte else []
        del cuts
        if not frame_input.subframes:
            start = time.perf_counter()
            description = describe_frame(frame_input)
            seconds["describe"] = time.perf_counter() - start
            frame_input = replace(frame_input, displayed=())  # or it would be held twice
        camera, quality = frame_input.camera, frame_input.quality
        samples = math.prod(quality.window_of((camera.width, camera.height)).size) * quality.spp
        samples *= 2 if camera.baseline_m else 1
        taken = 0

        def count(more: int) -> None:
            nonlocal taken
            taken += more
            watch(taken, samples)

        layers = render_frame(frame_input, frame, count, description)
        if layers.coverage:
            layers = with_mattes(layers, {each.object: (each.name, each.of) for each in found})
        return replace(
            layers,
            seconds=seconds | layers.seconds,
            statistics=layers.statistics | frame_input.counts,
        )

    def header(self, frame: int) -> dict[str, Any]:
        """Make the header of a frame's file: all that determines its pixels."""
        fps = self._preset.camera.fps
        header = frame_header(self._scene.camera(frame), fps, self.settings, frame)
        return header | picture_windows(self._preset.render.size, self._preset.render.window)


MOST_TRIES = 3
"""How often a frame may kill its worker."""

MOST_ESTIMATED = 16
"""Frames of a sequence whose memory is estimated before the first of them is rendered."""

CHILD = (sys.executable, "-P", "-m", "scenes.render.render_files")
_ROOT = Path(__file__).resolve().parents[2]
_TICK_S = 0.5

Making = tuple[str, float, int]
"""What is made once and then kept, the steps done of it, and their number (``Follow``)."""

ProcessWatch = Callable[[int, int, int, Making | None], object]
"""Called twice a second, and whenever samples are taken or something is made, with the process's
id, the samples of the frame so far, how many it will have, and what is made before them."""

_MALLOC = {
    "MALLOC_MMAP_THRESHOLD_": str(2**23),
    "MALLOC_TRIM_THRESHOLD_": str(2**24),
    "GLIBC_TUNABLES": "glibc.malloc.hugetlb=1",
}
"""Settings of glibc's allocator in the process that renders.

The memory of an array of 8 MB and more goes back to the system as soon as the array is freed
(MMAP_THRESHOLD). Smaller arrays reuse memory, because asking the system again would cost more time
than the room is worth: up to 16 MB of free memory stay with the process (TRIM_THRESHOLD), which
threads would otherwise give back after each run of points. hugetlb=1 asks for large pages on
systems that give them only on request: the memory of a frame is new, and one large page takes the
place of 512 small ones that would have to be mapped one by one."""


class Worker(contextlib.AbstractContextManager):
    """Renders frames in a process of its own, which ends with the context.

    threads     for the renderer; 0 = one for each core
    most_bytes  that a frame may need of memory
    """

    def __init__(
        self,
        threads: int = 0,
        watch: ProcessWatch = _ignore,
        most_bytes: int | None = None,
    ) -> None:
        self._threads, self._watch, self._most_bytes = threads, watch, most_bytes
        self._process: subprocess.Popen[bytes] | None = None
        self._unread = b""
        self._settings: Settings | None = None

    def __exit__(self, *_: object) -> None:
        self.end()

    def __call__(self, settings: Settings, frame: int, target: Path) -> Record:
        """Render a frame into ``target``, as FrameSession.render does.

        The settings go to the process once, until others come. Raises what FrameSession raises, and
        FrameFailed for any other error and for a frame that has killed MOST_TRIES workers.
        """
        request = {"frame": frame, "target": str(target), "most_bytes": self._most_bytes}
        for _ in range(MOST_TRIES):
            if self._process is None:
                self._start(settings["render"]["variant"])
            if self._open_session(settings):
                found = self._ask(request)
                if found is not None:
                    return _record(found)
            target.unlink(missing_ok=True)
            why = self.end()
        raise FrameFailed(f"it ended its worker {MOST_TRIES} times ({why})", MOST_TRIES)

    def preflight(self, settings: Settings, frames: Sequence[int], folder: Path) -> None:
        """Raise InputError where one of these frames is estimated to need more than it may.

        A process that dies of it says nothing: the frames' own turns will tell.
        """
        if self._process is None:
            self._start(settings["render"]["variant"])
        request = {"preflight": frames, "folder": str(folder), "most_bytes": self._most_bytes}
        found = self._ask(request) if self._open_session(settings) else None
        if found is None:
            self.end()
        else:
            _record(found)

    def _open_session(self, settings: Settings) -> bool:
        """Send settings that the process does not have yet; gives whether it lives."""
        if self._settings == settings:
            return True
        self._settings = None
        found = self._ask({"settings": settings})
        if found is None:
            return False
        _record(found)
        self._settings = settings
        return True

    def end(self) -> str:
        """Kill the process, if there is one, and wait for its end; says how it ended."""
        process, self._process, self._unread = self._process, None, b""
        self._settings = None
        if process is None:
            return ""
        with process:  # closes both pipes
            code = process.poll()
            process.kill()
        return _how(process.returncode if code is None else code)

    def _start(self, variant: str) -> None:
        """Start the process, which no signal asks to end: this one ends it."""
        paths = os.pathsep.join([str(_ROOT), *filter(None, [os.environ.get("PYTHONPATH")])])
        with signals_held():
            self._process = subprocess.Popen(
                [*CHILD, str(os.getpid()), str(self._threads)],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                bufsize=0,
                env={**_MALLOC, **trusting(variant), "PYTHONPATH": paths},
            )
        if self._answer() is None:
            raise RuntimeError(f"the process that renders does not start ({self.end()})")

    def _ask(self, request: dict[str, Any]) -> dict[str, Any] | None:
        """Send a request and wait for the answer; None from a process that died."""
        assert self._process is not None and self._process.stdin is not None
        try:
            self._process.stdin.write(json.dumps(request).encode() + b"\n")
            self._process.stdin.flush()
        except BrokenPipeError:
            return None
        return self._answer()

    def _answer(self) -> dict[str, Any] | None:
        """The next line of the process, watched while it is awaited; None when it died."""
        assert self._process is not None and self._process.stdout is not None
        source = self._process.stdout.fileno()
        samples, of = 0, 0
        making: Making | None = None
        while True:
            line, end, rest = self._unread.partition(b"\n")
            if end:
                self._unread = rest
                found: dict[str, Any] = json.loads(line)
                if "making" in found:
                    what, done, steps = found["making"]
                    making = (what, done, steps) if done < steps or not steps else None
                elif "samples" in found:
                    making, (samples, of) = None, found["samples"]
                else:
                    return found
            elif select.select([source], [], [], _TICK_S)[0]:
                data = os.read(source, 2**16)
                if not data:
                    return None
                self._unread += data
                continue
            self._watch(self._process.pid, samples, of, making)


def render_left(job: Job, worker: Worker) -> Iterator[Record]:
    """Render what is not done as ``render_sequence`` does, with its memory estimated before.

    Of more than MOST_ESTIMATED frames so many are estimated, evenly spread, the first and the last
    among them. Raises InputError before any is rendered where one would need more than it may.
    """
    left = [frame for frame in job.paths if frame not in job.done]
    if len(left) > 1:
        if (n := len(left) - 1) >= MOST_ESTIMATED:
            left = [left[round(k * n / (MOST_ESTIMATED - 1))] for k in range(MOST_ESTIMATED)]
        worker.preflight(job.settings, left, job.folder)
    yield from render_sequence(job, worker)


def _record(found: dict[str, Any]) -> Record:
    """What the process answered, or the error that it met."""
    if "input" in found:
        where, arrived, rule, cure = found["input"]
        raise InputError(where, arrived, rule, cure)
    if "disk" in found:
        raise OSError(*found["disk"])
    if "failed" in found:
        raise FrameFailed(found["failed"], 1)
    record: Record = found["record"]
    return record


def _how(code: int) -> str:
    if code >= 0:
        return f"exit code {code}"
    name = signal.Signals(-code).name if -code in set(signal.Signals) else f"signal {-code}"
    return f"{name}, perhaps for want of memory" if code == -signal.SIGKILL else name


def answer(work: Callable[[], Record]) -> dict[str, Any]:
    """Do what is asked for; whatever goes wrong becomes an answer."""
    try:
        return {"record": work()}
    except InputError as error:
        return {"input": [error.where, error.arrived, error.rule, error.cure]}
    except OSError as error:
        return {"disk": [error.errno, error.strerror or str(error), error.filename]}
    except Exception as error:
        if os.environ.get("LODBENCH_TRACEBACK"):
            traceback.print_exc()
        text = " ".join(str(error).split())
        return {"failed": f"{type(error).__name__}: {text}" if text else type(error).__name__}


def serve(open_session: Callable[[Settings], Any]) -> None:
    """Answer every line of stdin until it ends. argv: the parent's number, threads (0 = all).

    A session is what a FrameSession is: it has ``preflight`` and ``render``.
    """
    parent, threads = map(int, sys.argv[1:3])
    end_with_parent(parent)
    open_standard_streams()
    answers = own_stdout()
    session: Any = None

    def say(data: dict[str, Any]) -> None:
        print(json.dumps(data, default=str), file=answers, flush=True)

    def watch(samples: int, of: int) -> None:
        say({"samples": [samples, of]})

    def work(request: dict[str, Any]) -> Record:
        nonlocal session
        if "settings" in request:
            session = None  # its world goes before another comes
            session = open_session(request["settings"])
            return {}
        record: Record
        if "preflight" in request:
            frames = request.pop("preflight")
            record = session.preflight(frames, **request)
        else:
            record = session.render(watch=watch, **request)
        return record

    say({"ready": os.getpid()})
    if threads:
        import drjit

        drjit.set_thread_count(threads)
    with followed_by(lambda *made: say({"making": made})), kernels_told():
        for line in sys.stdin:
            say(answer(partial(work, json.loads(line))))


@dataclass(frozen=True)
class Workers:
    """What renders frames.

    threads     for the renderer; 0 = as many as there are
    most_bytes  that a frame may need of memory, as of ``memory_limit``
    cluster     as scenes.render.cluster has it; None = a process of its own here
    """

    threads: int = 0
    most_bytes: int | None = None
    cluster: str | None = None


def settled(
    preset: Preset,
    pattern: str | Path,
    frames: Sequence[int],
    most_bytes: int | None = None,
    note: Callable[[str], object] = _ignore,
) -> Settings:
    """Settle what frames of a preset are rendered with: detail within budgets, variant, actors.

    The actors act, if they have not yet, into the folder of ``pattern`` (name.####.exr). Raises
    InputError for what cannot be, and for what is estimated to need more memory than it may.
    """
    chosen = within_budget(preset, frames, most_bytes, note)
    check_acted(chosen, frames, most_bytes)
    variant = choose(chosen.render.variant, chosen.render.spectral)
    return frame_settings(chosen, variant, prepare_track(chosen, make_folder(Path(pattern).parent)))


def render_files(
    settings: Settings,
    pattern: str | Path,
    frames: Sequence[int],
    workers: Workers = Workers(),
    overwrite: bool = False,
    watch: ProcessWatch = _ignore,
    note: Callable[[str], object] = _ignore,
) -> Iterator[Record]:
    """Render frames that are not there yet into ``pattern``, giving a record after each.

    Raises InputError for frames of other settings that stand there, unless ``overwrite``, and while
    another process renders other settings into that folder. See ``render_job`` for the rest.
    """
    with owned_folder(make_folder(Path(pattern).parent), settings, note):
        yield from render_job(open_job(pattern, frames, settings, overwrite), workers, watch, note)


def render_job(
    job: Job, workers: Workers, watch: ProcessWatch, note: Callable[[str], object]
) -> Iterator[Record]:
    """Render the frames of a job that are not done, giving a record after each.

    ``watch`` follows the samples of a frame that is rendered here; ``note`` is called with what
    someone who waits may want to know.
    """
    if workers.cluster is None:
        with Worker(workers.threads, watch, workers.most_bytes) as worker:
            yield from render_left(job, worker)
        return
    from scenes.render.cluster import cluster, render_on_cluster, sweep

    limits = workers.threads, job.settings["render"]["variant"], workers.most_bytes
    try:
        with cluster(workers.cluster, *limits, note) as several:
            yield from render_on_cluster(job, several)
    finally:
        sweep(job)


if __name__ == "__main__":
    serve(FrameSession)
