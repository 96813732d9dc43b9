"""What takes time beside whole frames: compiled walks, commands from the shell, ways to sample.

``speed`` holds the compiled walks against the bytes that must move, ``start`` commands against the
imports that they need and the rays of a frame, and ``settings`` the way that frames are sampled
against others, by noise times processor's time. They are topics of the experiment ``cost``.
"""

import json
import os
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numba
import numpy as np

from bench.children import run_timed
from bench.experiment import Table
from bench.frame_costs import interleaved_seconds
from bench.records.claims import Claim, at_most, claim
from bench.records.records import Column, Point, Record, columns, grouped, where
from bench.statistics.estimates import LEAST_REPEATS, two_sided_factor, two_sided_median
from lod.arrays import Reals
from lod.crossfade import blend_weights
from lod.pruner import prune
from lod.view import View
from scenes.field.cells import candidates, cells_in_reach
from scenes.field.species_field import SpeciesField
from scenes.field.traversal import node_limits, traverse
from scenes.presets.load import load_preset
from scenes.processes.cache import VARIABLE
from scenes.render.render import build_frame, trace
from scenes.render.variants import JIT_VARIANT, SCALAR_VARIANT
from scenes.scene import Scene

SAMPLES = 25
"""Samples of a pixel where ways to sample are compared: orthogonal arrays take primes squared."""

TIMES = "imports_us", "trace_us", "command_us", "command_cpu_us"
"""Columns of a command's turns: wall time of its imports alone, of rays, and of all; CPU time."""

DARK = 1e-2
"""The number added to the squared radiance by which noise is divided, ÷ its mean square."""


def measure_walks(size: str, repeats: int, seed: int) -> list[Point]:
    """Time part tests, sticks posed and emitted, and objects turned away [ns].

    Turned away are objects that were drawn, beyond limits a thirtieth of the view's; their time
    bears that of all cells, and of the few objects that are kept. ``floor_bytes`` are those that a
    traversal must move.
    """
    numba.set_num_threads(1)
    source = np.ones(2**25)
    target = np.zeros_like(source)
    (copied,) = interleaved_seconds([lambda: np.copyto(target, source)], repeats)
    nanoseconds = [round(1e9 * t) for t in copied]
    points = [
        Point(
            {"topic": "speed", "what": "copy"},
            samples=columns({"bytes": [2 * source.nbytes], "ns": nanoseconds}),
        )
    ]
    for name, preset, species in (("trees", "meadow", "tree"), ("figures", "crowd", "figure")):
        scene = Scene(load_preset(preset, [f"render.size={size}", f"seed={seed}"]))
        (field,) = (each for each in scene.world.fields if each.name == species)
        samples = _walks_over(field, scene.view(1), repeats)
        points.append(Point({"topic": "speed", "what": name}, samples=samples))
    return points


def _walks_over(field: SpeciesField, view: View, repeats: int) -> tuple[Column, ...]:
    cut = prune(field, view)
    instances, weights = cut.parts.state.instances, blend_weights(cut, view)
    nodes, poses = field.prototypes.traversal_tables, field.prototypes.pose_tables
    limits = node_limits(nodes, field.prototypes.part_tables, view, 0.0)
    still = np.zeros(len(instances.prototype))
    coarse = View(view.camera, view.metric, view.detail * 30.0, view.offscreen_detail)
    bounds, beyond = field.search_bounds(view), field.search_bounds(coarse)

    def turn_away() -> int:
        visited = cells_in_reach(field.cells, view, bounds)
        return candidates(field.cells, view, beyond, visited)[1]

    tasks: dict[str, Callable[[], int]] = {
        "tests": lambda: traverse(poses, nodes, limits, instances, still, view).examined,
        "sticks": lambda: len(field.appearance(cut.parts, weights)),
        "turned away": turn_away,
    }
    counts = {task: count() for task, count in tasks.items()}
    timed = interleaved_seconds(list(tasks.values()), repeats)
    # A traversal writes 12 bytes for each displayed part, and reads 56 of each object.
    samples = [Column("floor_bytes", [12 * len(cut) + 56 * len(still)])]
    for (task, count), row in zip(counts.items(), timed, strict=True):
        found = {"count": [count], "ns": [round(1e9 * t) for t in row]}
        samples += columns(found, task=task)
    return tuple(samples)


def speed_tables(record: Record) -> Iterator[tuple[str, Table]]:
    """Show rates, and the time of part tests against that of the bytes that must move."""
    (copied,) = where(record.points, what="copy")
    speed = copied.column("bytes")[0] / (np.median(copied.values("ns")) / 1e9)
    rows: list[tuple[str, ...]] = [("memory moved by a copy", "", f"{speed / 1e9:.1f} GB/s")]
    for point in record.points:
        if point is copied:
            continue
        name = point.case["what"]
        for task in ("tests", "sticks", "turned away"):
            n, ns = point.column("count", task=task)[0], point.values("ns", task=task)
            rows.append((f"{name}: {task}", f"{n:,}", f"{two_sided_median(1e3 * n / ns):.1f} M/s"))
        floor_ns = 1e9 * point.column("floor_bytes")[0] / speed
        over = np.median(point.values("ns", task="tests")) / floor_ns
        rows.append((f"{name}: time of tests ÷ floor", "", f"{over:.1f}"))
    yield "Compiled walks on one core", (("on one core", "how many", "median (95 %)"), rows)


def measure_command(
    words: tuple[str, ...], warm: int, cold: int, variants: Sequence[str], seed: int
) -> list[Point]:
    """Time a command and its imports, in turns with the same in other variants.

    words     after ``lodbench``; of a first frame, without the folder it goes to
    warm      turns with a folder of what is kept, the last cold one's; ``cold`` turns begin with
              nothing kept, neither by lodbench nor, below the home folder, by Dr.Jit
    variants  that frames are rendered in; none for a command that renders nothing
    """
    rows: dict[tuple[str, str], list[list[int]]] = {}
    with tempfile.TemporaryDirectory() as folder:

        def turn(variant: str, cache: Path) -> list[int]:
            imports, own = "import numpy, numba, scipy, pydantic, click", words
            if variant:
                imports += f", drjit, OpenEXR, mitsuba; mitsuba.set_variant({variant!r})"
                target = str(Path(folder) / "a.####.exr")
                own += "-o", target, "--overwrite", "--json", "--variant", variant
            environment = {k: v for k, v in os.environ.items() if k != "NUMBA_CACHE_DIR"}
            environment |= {VARIABLE: str(cache), "HOME": str(cache)}
            cache.mkdir(exist_ok=True)
            _, imported_s, _ = run_timed((sys.executable, "-c", imports), environment)
            command = sys.executable, "-m", "lodbench", *own
            said, wall_s, cpu_s = run_timed(command, environment)
            traced_s = json.loads(said.splitlines()[0])["seconds"]["trace"] if variant else 0.0
            return [round(1e6 * s) for s in (imported_s, traced_s, wall_s, cpu_s)]

        last = max(cold - 1, 0)
        turns = [("cold" if cold else "", str(k)) for k in range(last + 1)]
        for how, name in turns + [("warm", str(last))] * warm:
            for variant in variants or ("",):
                found = turn(variant, Path(folder, name + variant))
                rows.setdefault((variant, how), []).append(found)
    topic, command = "variants" if len(variants) > 1 else "start", f"lodbench {' '.join(words)}"
    return [
        Point(
            {"topic": topic, "command": command, "variant": variant, "kept": how},
            samples=columns(dict(zip(TIMES, map(list, zip(*row, strict=True)), strict=True))),
        )
        for (variant, how), row in rows.items()
        if how
    ]


def _over_imports(point: Point) -> Reals:
    names = "command_us", "imports_us", "trace_us"
    command, imports, traced = (point.values(name) for name in names)
    return np.asarray(command / (imports + traced))


def variants_claims(points: Sequence[Point]) -> Iterator[Claim]:
    """Bound the time to trace a frame in scalar code by that in LLVM's, turn by turn."""
    for (command,), both in grouped(where(points, kept="warm"), "command").items():
        scalar, jit = (where(both, variant=v)[0] for v in (SCALAR_VARIANT, JIT_VARIANT))
        found = two_sided_factor(scalar.values("trace_us") / jit.values("trace_us"))
        estimand, of = f"time to trace, {SCALAR_VARIANT} ÷ {JIT_VARIANT}", {"command": command}
        yield claim(estimand, at_most(8), of, found, unit="turn", source="asked")


def start_claims(points: Sequence[Point]) -> Iterator[Claim]:
    """Bound the time of warm commands by that of their imports and rays, and of cold frames."""
    for point in points:
        of, traced = {"command": point.case["command"]}, bool(point.values("trace_us").any())
        found, unit = _over_imports(point), "÷ its imports"
        if len(found) < LEAST_REPEATS:
            continue
        if point.case["kept"] == "warm":
            unit, bound = ("÷ its imports and trace", 1.5) if traced else ("÷ its imports", 2)
        elif traced:
            found, unit, bound = point.values("command_us") / 1e6, "with nothing kept [s]", 60
        else:
            continue
        told = f"time of a command {unit}", at_most(bound), of, two_sided_median(found)
        yield claim(*told, unit="turn", source="asked")


def start_tables(record: Record) -> Iterator[tuple[str, Table]]:
    """Show what imports, trace and command take, medians, with intervals of enough turns."""
    heads = "command", "imports [s]", "trace [s]", "command [s]", "command [CPU s]"
    rows: list[tuple[str, ...]] = []
    for point in record.points:
        taken = [*(point.values(name) / 1e6 for name in TIMES), _over_imports(point)]
        median = two_sided_median if len(taken[0]) >= LEAST_REPEATS else np.median
        told = (f"{median(each):.2f}" for each in taken)
        rows.append(
            (
                f"{point.case['command']} {point.case.get('variant', '')}, {point.case['kept']}",
                *told,
            )
        )
    yield "Commands from the shell", ((*heads, "command ÷ (imports + trace)"), rows)


def sampling_settings() -> dict[str, dict[str, Any]]:
    """Return the ways to sample that are tried, with what of ``Quality`` they change.

    The first is the one in use, and the last traces the deepest paths.
    """
    kinds = "independent", "stratified", "orthogonal"
    samplers = {f"sampler {k}": {"sampler": k} for k in kinds}
    sizes = {f"2^{k} samples at once": {"most_samples": 2**k} for k in (16, 18, 21)}
    depths = {f"paths of {n} edges": {"max_depth": n} for n in (2, 3, 6, 16)}
    return {"as used": {}, **samplers, **sizes, **depths}


def measure_sampling(preset: str, size: str, pairs: int, seed: int) -> list[Point]:
    """Render one scene by every setting with pairs of independent seeds, in turns.

    Noise is the mean over pixels of (a − b)²/2 over the squared light of the mean of all pictures,
    which holds no bias [millionths]; time is that of the processor, on all cores, for the trace
    alone, once its code is compiled. ``light`` is the mean radiance [millionths].
    """
    keys = f"render.size={size}", f"render.spp={SAMPLES}", f"seed={seed}"
    made = Scene(load_preset(preset, keys)).input(1, JIT_VARIANT)
    settings = sampling_settings()
    qualities = [replace(made.quality, **changes) for changes in settings.values()]
    built = [build_frame(replace(made, quality=each)) for each in qualities]
    spent: list[list[int]] = [[] for _ in built]
    pictures: list[list[np.ndarray]] = [[] for _ in built]
    for number in (2**20, *range(2 * pairs)):  # the first compiles
        for k, scene in enumerate(built):
            start = time.process_time()
            layers = trace(scene, replace(qualities[k], seed=number), 1)
            if number < 2**20:
                spent[k].append(round(1e6 * (time.process_time() - start)))
                pictures[k].append(np.asarray(layers.rgb, np.float64))
    whole = [k for k, changes in enumerate(settings.values()) if "max_depth" not in changes]
    light = np.mean([np.mean(pictures[k], axis=0) for k in whole], axis=0)
    points = []
    for name, held, times in zip(settings, pictures, spent, strict=True):
        found = [noise_of_pair(*pair, light) for pair in zip(held[::2], held[1::2], strict=True)]
        samples = {
            "noise_ppm": [round(1e6 * each) for each in found],
            "cpu_us": np.add.reduceat(times, np.arange(0, len(times), 2)).tolist(),
            "light_ppm": [round(1e6 * float(np.mean(held)))],
        }
        named = {"topic": "settings", "preset": preset, "setting": name}
        points.append(Point(named, samples=columns(samples)))
    return points


def noise_of_pair(a: np.ndarray, b: np.ndarray, light: np.ndarray) -> float:
    """Return the variance of a picture ÷ its squared light, to which a hundredth is added."""
    squared = light**2
    return float(((a - b) ** 2 / 2 / (squared + DARK * squared.mean())).mean())


def settings_tables(record: Record) -> Iterator[tuple[str, Table]]:
    """Show noise × time over that of the way in use, pair by pair: below 1 is better.

    Light tells what a way leaves out: mean radiance over that of the deepest paths tried.
    """
    rows: list[tuple[str, ...]] = []
    for (preset,), row in grouped(record.points, "preset").items():
        used, deepest = row[0], row[-1].column("light_ppm")[0]
        cost = used.values("noise_ppm") * used.values("cpu_us")
        for point in row:
            noise, spent = point.values("noise_ppm"), point.values("cpu_us")
            enough = len(noise) >= LEAST_REPEATS
            beside = noise * spent / cost
            rows.append(
                (
                    *(preset, point.case["setting"], f"{np.median(noise) / 1e6:.4f}"),
                    f"{np.median(spent) / 2e6:.2f}",
                    f"{two_sided_median(beside):.2f}" if enough else f"{np.median(beside):.2f}",
                    f"{point.column('light_ppm')[0] / deepest:.3f}",
                )
            )
    heads = "preset", "setting", "noise", "processor s", "noise × time, of that used", "light"
    yield "Ways to sample, noise × time of the one in use", (heads, rows)
