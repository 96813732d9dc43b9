"""What commands take from the shell, against the imports that they need and the rays of a frame.

Topics ``start`` and ``variants`` of the experiment ``cost``.
"""

import json
import os
import sys
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from bench.children import run_timed
from bench.experiment import Table
from bench.records.claims import Claim, at_most, claim
from bench.records.records import Point, Record, columns, grouped, where
from bench.statistics.estimates import LEAST_REPEATS, two_sided_factor, two_sided_median
from lod.arrays import Reals
from scenes.processes.cache import VARIABLE
from scenes.render.variants import JIT_VARIANT, SCALAR_VARIANT

TIMES = "imports_us", "trace_us", "command_us", "command_cpu_us"
"""Columns of a command's turns: wall time of its imports alone, of rays, and of all; CPU time."""


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
