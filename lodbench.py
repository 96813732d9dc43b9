"""lodbench in Python: load a preset, count and render its frames, run an experiment.

>>> import lodbench
>>> meadow = lodbench.load_preset("meadow", {"render.size": "64x36", "render.spp": 4})
>>> counts = lodbench.count(meadow)
>>> frame = lodbench.render(meadow)
>>> frame.layers.Z.shape
(36, 64)

These names are stable. All else in the packages ``lod``, ``scenes`` and ``bench`` may change from
one release to the next. Nothing heavy is imported before the function that needs it is called.
"""

import sys
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any, SupportsIndex

import numpy as np
from numpy.typing import NDArray

if _others := [
    each.origin
    for each in map(find_spec, ("lod", "scenes", "bench"))
    if each
    and each.origin
    and Path(each.origin).resolve().parents[1] != Path(__file__).resolve().parent
]:
    raise ImportError(f"{_others[0]} hides a package of lodbench: rename it, or start elsewhere")

from lod.errors import InputError
from scenes.frame.layers import SKY_Z, Layers
from scenes.presets.load import Setting
from scenes.presets.load import load_preset as _load_preset
from scenes.presets.schema import Preset

if TYPE_CHECKING:
    from bench.frame_counts import Counts
    from bench.records.records import Record
    from lod.metric import Metric
    from lod.pruner import Representation

__all__ = [
    "SKY_Z",
    "Frame",
    "InputError",
    "Layers",
    "Metric",
    "Preset",
    "Representation",
    "count",
    "load_preset",
    "read_frame",
    "render",
    "render_sequence",
    "run_experiment",
]


def __getattr__(name: str) -> Any:
    """Import what metrics and representations are made of when it is asked for."""
    if name == "Metric":
        from lod.metric import Metric

        return Metric
    if name == "Representation":
        from lod.pruner import Representation

        return Representation
    raise AttributeError(f"module 'lodbench' has no attribute {name!r}")


def __dir__() -> list[str]:
    """List what is imported when it is asked for, too."""
    return sorted({*globals(), *__all__})


@dataclass(frozen=True, eq=False)
class Frame:
    """A rendered frame: its layers as NumPy arrays, and the header that its file has.

    layers  colour, depth, normals, albedo and ids, rows from the top; see ``Layers``
    header  attributes by name; every setting that made the frame is below ``lod:preset.``
    """

    layers: Layers
    header: dict[str, Any]

    def preview(
        self, tone: str = "filmic", exposure: float = 0.0, view: str = "colour"
    ) -> NDArray[np.uint8]:
        """Make the picture that `lodbench render --preview` makes, 8-bit sRGB, (h, w, 3).

        tone      ``filmic``, ``reinhard`` or ``linear``
        exposure  stops above the one that fits the picture
        view      ``colour``, ``level`` for the level of detail of each pixel, or ``species`` for
                  both the level and the species
        Raises InputError for other words, and for an exposure beyond 20 stops.
        """
        from scenes.render.pictures import PictureStyle, preview_pixels

        look = PictureStyle(tone, exposure, view)
        exposure_of = look.exposure_of(self.layers.rgb)
        return preview_pixels(self.layers, look, exposure_of, self.header)


@contextmanager
def _callers_variant() -> Iterator[None]:
    """Leave Mitsuba's variant as the caller has chosen it."""
    mitsuba = sys.modules.get("mitsuba")
    before = mitsuba and mitsuba.variant()
    try:
        yield
    finally:
        if mitsuba and before:
            mitsuba.set_variant(before)


def _in_notebook() -> bool:
    return "ipykernel" in sys.modules


@contextmanager
def _followed(watch: Callable[..., Any] | None) -> Iterator[Callable[..., Any]]:
    """Have what is done inside followed by a caller's function, or by a bar in a notebook."""
    if watch or not _in_notebook():
        yield watch or (lambda *_: None)
        return
    from tqdm.auto import tqdm

    from scenes.processes.progress import followed_by

    with tqdm(leave=False) as bar:

        def show(done: float, total: float, what: str = "samples") -> None:
            bar.n, bar.total = done, total
            bar.set_description(what)

        with followed_by(lambda what, done, steps: show(done, steps, what)):
            yield show


def load_preset(name_or_path: str | Path, changes: Mapping[str, Any] | None = None) -> Preset:
    """Load a preset by its name or the path of its TOML file.

    changes  new values by dotted key, as ``{"camera.height": 20.0, "view.metric": "bounded"}``;
             `lodbench list --keys` lists the keys with unit, range and meaning
    Raises InputError, in one line, for a preset or a value that cannot be.
    """
    settings = [Setting(key, key, value) for key, value in (changes or {}).items()]
    return _load_preset(str(name_or_path), settings)


@_callers_variant()
def count(preset: Preset | str | Path, frame: SupportsIndex = 1) -> "Counts":
    """Prune a frame without rendering it, and hold its counts against the law.

    The result has objects and parts (each ``examined``, ``displayed``, ``predicted`` and the
    standard deviation ``predicted_sd`` of that), by species and by level. Raises InputError for a
    preset or frame that cannot be, or a budget that no detail meets.
    """
    from bench.frame_counts import count as count_view
    from scenes.files import checked_frames
    from scenes.render.budget import within_budget
    from scenes.scene import Scene

    (number,) = checked_frames((frame,), "frame")
    scene = Scene(within_budget(_preset(preset), (number,)))
    return count_view(scene.world, scene.view(number))


@_callers_variant()
def render(
    preset: Preset | str | Path,
    frame: SupportsIndex = 1,
    watch: Callable[[int, int], object] | None = None,
) -> Frame:
    """Render one frame in this process, into arrays and no file.

    watch  function that is called now and then with the samples taken so far, and their number in
           all; by default a notebook shows a bar
    Raises InputError for what cannot be rendered. The first call compiles kernels, which takes
    longer once on a machine.
    """
    from scenes.files import checked_frames
    from scenes.render.budget import within_budget
    from scenes.render.exr.header import frame_settings
    from scenes.render.frame_session import FrameSession
    from scenes.render.variants import choose

    (number,) = checked_frames((frame,), "frame")
    chosen = within_budget(_preset(preset), (number,))
    variant = choose(chosen.render.variant, chosen.render.spectral)
    session = FrameSession(frame_settings(chosen, variant))
    with _followed(watch) as follow:
        layers = session.render_layers(number, follow)
    return Frame(layers, session.header(number))


def render_sequence(
    preset: Preset | str | Path,
    pattern: str | Path,
    frames: Iterable[SupportsIndex],
    overwrite: bool = False,
    threads: int = 0,
) -> Iterator[dict[str, Any]]:
    """Render frames into files ``pattern`` (as ``out/name.####.exr``), as `lodbench render` does.

    frames   whole numbers from 1 on, as range(1, 25) or an array
    threads  for the renderer, in a process of its own; 0 = one for each core
    Yields a record after each frame, and shows a bar in a notebook: ``frame``, ``path`` (absolute),
    ``sha256``, ``kept`` (it was there already), ``seconds`` by stage; a frame that failed has
    ``error`` instead. Raises InputError for frames that cannot be, for those of other settings that
    stand there, unless ``overwrite``, and while another process renders other settings into that
    folder.
    """
    from scenes.files import check_pattern, checked_frames
    from scenes.render.render_files import Workers, render_files, settled

    check_pattern(pattern)
    numbers, path = checked_frames(frames), Path(pattern).absolute()
    settings = settled(_preset(preset), path, numbers)
    records = render_files(settings, path, numbers, Workers(threads), overwrite)
    if not _in_notebook():
        return records
    from tqdm.auto import tqdm

    return iter(tqdm(records, total=len(numbers), unit="frame", leave=False))


def read_frame(path: str | Path) -> Frame:
    """Read a frame that lodbench wrote. Raises InputError for any other file."""
    from scenes.render.exr.layer_file import read_exr

    return Frame(*read_exr(path))


@_callers_variant()
def run_experiment(
    name: str,
    quick: bool = False,
    seed: int = 0,
    watch: Callable[[int, int, str], object] | None = None,
) -> "Record":
    """Run an experiment in this process, and give its record with points and claims; no file.

    name   of an experiment or topic, as `lodbench list` shows it
    quick  measure fewer points, in minutes
    watch  function that is called with the cases measured, their number in all, and the name of the
           next; by default a notebook shows a bar
    Raises InputError for an unknown name.
    """
    from bench.experiment import experiments, topics_named
    from bench.runs import RunRequest, serial_executor
    from bench.runs import run_experiment as run

    chosen = topics_named([name])
    if len(chosen) > 1:
        raise InputError("name", name, "one experiment or topic", f"try {next(iter(chosen))}")
    ((experiment, topics),) = chosen.items()
    asked = RunRequest(experiment, tuple(topics), quick, seed)
    with _followed(watch) as follow:
        return run(experiments()[experiment], asked, serial_executor, follow)


def _preset(preset: Preset | str | Path) -> Preset:
    return preset if isinstance(preset, Preset) else load_preset(preset)


if __name__ == "__main__":
    from bench.cli.main import main

    main()
