"""Folders of frames that are killed, damaged, shared and starved at random: what is lost?

Runs the program itself, with frames of 32x18 pixels, and does to it and to its folders what nights
do to renderers: signals at random moments, processes killed, files and manifests damaged, several
commands at once on one folder, disks that are full or read-only, readers that go away, workers of a
cluster that die. Everything is drawn from one seed. After each step the folder is held against the
bytes of the same frames rendered alone, and against what the program promised.
"""

import json
import shutil
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import asdict, dataclass, field, replace
from itertools import count, takewhile
from pathlib import Path
from typing import Any

import click

from bench.cli.output import table
from bench.records.provenance import provenance, scene_digest
from bench.studies.soak.disk import mounts, small_disk
from bench.studies.soak.judge import KINDS, Broken
from bench.studies.soak.looks import FRAMES, LOOKS, PRESET, PRESET_NAME, Truth, frame_name
from bench.studies.soak.place import Place
from bench.studies.soak.plan import Command, Round, plan_round
from bench.studies.soak.rounds import Folder
from scenes.render.exr.sequence import file_hash
from scenes.render.variants import SCALAR_VARIANT, choose, trusting

_LONGEST_TEXTS = 40


@dataclass
class Figures:
    """What a soak tried, how often each promise was broken, and how that was seen."""

    tried: Counter[str] = field(default_factory=Counter)
    broken: Counter[str] = field(default_factory=Counter)
    texts: list[str] = field(default_factory=list)

    def add(self, plan: Round, tried: Mapping[str, int], broken: list[Broken]) -> None:
        """Add a round."""
        self.tried.update({"rounds": 1, **tried})
        for each in broken:
            self.broken[each.kind] += each.times
            if len(self.texts) < _LONGEST_TEXTS:
                self.texts.append(f"round {plan.number}: {each.kind}: {each.text}")


def soak(
    plans: Iterable[Round], variant: str, keep: Path, say: Callable[[str], object], figures: Figures
) -> None:
    """Do rounds, each in a folder below ``keep``, where those that broke something stay.

    ``say`` is told of every action before it is taken; ``figures`` grow with every round.
    """
    variant = choose(variant)
    environment = trusting(variant)
    truth = render_alone(_place(keep / "alone", "out", variant, environment))
    for plan in plans:
        place = _place(keep / f"round{plan.number}", plan.folder, variant, environment)
        folder = _do_round(plan, place, truth, say)
        figures.add(plan, folder.tried, folder.broken)
        for each in folder.broken:
            say(f"BROKEN {each.kind}: {each.text}")
        if not folder.broken:
            shutil.rmtree(place.folder.parent)
    shutil.rmtree(keep / "alone")


def render_alone(place: Place) -> Truth:
    """Render every look in a folder of its own."""
    running = {}
    for look in LOOKS:
        alone = replace(place, out=look)
        running[look] = alone.start(Command("render", look), place.folder.parent / "logs" / look)
        if len(running) == 1:
            running[look].process.wait()  # it may compile kernels, which all others then find
    hashes = {}
    for look, each in running.items():
        each.process.wait()
        if (run := each.end()).code:
            raise click.ClickException(f"{look} cannot be rendered at all: {run.err}")
        paths = {frame: place.folder / look / frame_name("a", frame) for frame in FRAMES}
        hashes[look] = {frame: file_hash(path) for frame, path in paths.items()}
    if len({each for look in hashes.values() for each in look.values()}) < len(LOOKS) * len(FRAMES):
        raise click.ClickException("frames of other settings have the same bytes")
    return Truth(hashes)


def _place(base: Path, out: str, variant: str, environment: Mapping[str, str]) -> Place:
    """Make the folders of a round: where the program runs, its temporary files, its output."""
    for name in ("run", "tmp", "logs"):
        (base / name).mkdir(parents=True)
    (base / "run" / PRESET_NAME).write_text(PRESET, encoding="utf-8")
    if out == "link":
        (base / "linked").mkdir()
        (base / "run" / out).symlink_to(base / "linked")
    return Place(base / "run", out, variant, {**environment, "TMPDIR": str(base / "tmp")})


def _do_round(plan: Round, place: Place, truth: Truth, say: Callable[[str], object]) -> Folder:
    """Do a round from its plan, and heal what it leaves."""
    say(f"round {plan.number} in {plan.folder!r}, disk {plan.disk_kb or 'as it is'}")
    if plan.disk_kb is not None and not mounts():
        place = replace(place, file_kb=plan.disk_kb // 8)
    with small_disk(place.frames.resolve(), plan.disk_kb) as disk:
        folder = Folder(place, disk, truth, say)
        if plan.disk_kb is not None:
            folder.tried["small disks"] += 1
        for step in plan.steps:
            folder.do(step)
        folder.heal()
        if disk.folder is not None and folder.broken:
            shutil.copytree(disk.folder, place.folder.parent / "disk")
    return folder


def _numbers(minutes: float) -> Iterator[int]:
    """Count rounds, as long as there is time to begin another."""
    end = time.monotonic() + 60 * minutes
    yield from takewhile(lambda number: time.monotonic() < end, count())


@click.command()
@click.option("--minutes", type=click.FloatRange(0), default=60.0, show_default=True)
@click.option("--seed", type=int, help="Of everything that is drawn; a new one each time if none.")
@click.option("--round", "only", type=int, help="This one alone, to see again what it broke.")
@click.option("--variant", default=SCALAR_VARIANT, show_default=True, metavar="NAME")
@click.option("-o", "folder", type=click.Path(path_type=Path), help="Where broken rounds stay.")
@click.option("--json", "as_json", is_flag=True, help="One JSON object on stdout.")
def command(
    minutes: float,
    seed: int | None,
    only: int | None,
    variant: str,
    folder: Path | None,
    as_json: bool,
) -> None:
    """Soak, print what was tried and what broke; 1 when anything did."""
    seed = int(time.time()) if seed is None else seed
    keep = Path(tempfile.mkdtemp(prefix="soak-", dir=folder)).resolve()
    start = time.monotonic()

    def say(text: str) -> None:
        click.echo(f"{time.monotonic() - start:7.1f} s  {text}", err=True)

    say(f"seed {seed}, in {keep}")
    plans = (plan_round(seed, k) for k in (_numbers(minutes) if only is None else (only,)))
    figures = Figures()
    try:
        soak(plans, variant, keep, say, figures)
    finally:
        found = _found(figures, time.monotonic() - start, seed, choose(variant))
        click.echo(json.dumps(found) if as_json else _text(found))
    if sum(figures.broken.values()):
        first = figures.texts[0].replace("\n", " ")
        raise click.ClickException(f"seed {seed}, {first}; all of it in {keep}")
    keep.rmdir()


def _found(figures: Figures, seconds: float, seed: int, variant: str) -> dict[str, Any]:
    """Put together what was tried and what broke, and where that was."""
    scene = scene_digest([PRESET, sorted(LOOKS.items()), FRAMES])
    return {
        "seconds": round(seconds),
        "provenance": asdict(provenance(scene, seed, variant=variant)),
        "small disks are": "tmpfs" if mounts() else "a limit on the size of a file",
        "tried": dict(sorted(figures.tried.items())),
        "broken": {kind: figures.broken[kind] for kind in KINDS},
        "how": figures.texts,
    }


def _text(found: Mapping[str, Any]) -> str:
    """Write figures for people."""
    rows = [*found["tried"].items(), ("", None), *found["broken"].items()]
    source = found["provenance"]
    head = f"seed {source['seed']}, {found['seconds']} s, {source['variant']}, {source['commit']}"
    return "\n".join([head, f"small disks are {found['small disks are']}", table(rows)])
