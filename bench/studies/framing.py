"""Do panoramas and stereo pairs display as many objects and parts as the law says?

Fields of people that differ in their seed alone are pruned on flat ground: all round as a
panorama, and for two eyes, all round and in their field of view, near each other as a viewer's are
and so far apart that the baseline is much of D. Each is held against the law.
"""

from itertools import product
from operator import itemgetter
from pathlib import Path
from typing import Any

import click
import numpy as np

from bench.cli.output import counted, table
from bench.frame_counts import predict
from bench.records.study_record import study_record, write_study_record
from bench.statistics.estimates import LEAST_REPEATS, two_sided_mean
from lod.pruner import prune
from scenes.presets.load import load_preset
from scenes.scene import view_at
from scenes.world.world import build_world

WITHIN = 0.01
"""How far from 1 a ratio may be: its whole interval must lie within."""

PRESET = "crowd"
SCENE = (
    *("terrain.amplitude=0", "camera.height=1.6", "species.figure.density=0.3"),
    *("species.tree.density=0", "render.size=1024x512", "view.detail=4"),
)
"""Keys of all fields: flat ground, and people enough for narrow intervals."""

FRAMINGS = {
    "panorama": ("camera.projection=panorama", "view.detail=1"),
    "pair, 65 mm apart, all round": ("camera.stereo=0.065", "view.look_around=true"),
    "pair, 65 mm apart, in view": ("camera.stereo=0.065",),
    "pair, 10 m apart, all round": ("camera.stereo=10", "view.look_around=true"),
    "pair, 10 m apart, in view": ("camera.stereo=10",),
}
"""Each way of framing, and the keys that ask for it."""


def counts_of(keys: tuple[str, ...], seed: int) -> np.ndarray:
    """Count objects and parts displayed and predicted of one field, (2, 2)."""
    chosen = load_preset(PRESET, [*SCENE, *keys, f"seed={seed}"])
    world = build_world(chosen)
    view = view_at(world, chosen, 1)
    found = np.zeros((2, 2))
    for each in world.fields:
        cut, law = prune(each, view), predict(each, view)
        assert law is not None  # the metrics of presets have a law
        found[0] += cut.displayed_objects, cut.displayed_parts
        found[1] += each.species.density * np.array((law.objects, law.parts))
    return found


def ratios(fields: list[np.ndarray]) -> dict[str, Any]:
    """Estimate displayed ÷ predicted objects and parts, with 95 % intervals, of fields' counts."""
    counts = np.array(fields)
    found: dict[str, Any] = {"objects_a_field": float(counts[:, 0, 0].mean())}
    for k, name in enumerate(("objects", "parts")):
        each = two_sided_mean(counts[:, 0, k] / counts[:, 1, k])
        found[name] = {"ratio": each.value, "low": each.low, "high": each.high}
    return found


def report(found: dict[str, dict[str, Any]]) -> str:
    """Write the ratios as a table."""
    rows: list[tuple[object, ...]] = [("", "of", "displayed / law's", "95 % from", "to", "within")]
    for framing, each in found.items():
        for name in ("objects", "parts"):
            numbers = [each[name][key] for key in ("ratio", "low", "high")]
            inside = 1 - WITHIN <= numbers[1] and numbers[2] <= 1 + WITHIN
            verdict = f"{WITHIN:.0%}" if inside else "no"
            rows.append((framing, name, *(f"{each:.4f}" for each in numbers), verdict))
    return table(rows)


@click.command()
@click.option("--fields", type=click.IntRange(LEAST_REPEATS), default=16, show_default=True)
@click.option("--record", type=click.Path(path_type=Path), help="A file for the figures.")
def command(fields: int, record: Path | None) -> None:
    """Prune fields of people in every framing, and print displayed over predicted."""
    counts: dict[str, list[np.ndarray]] = {framing: [] for framing in FRAMINGS}
    for framing, seed in counted([*product(FRAMINGS, range(fields))], "field", itemgetter(0)):
        counts[framing].append(counts_of(FRAMINGS[framing], seed))
    found = {framing: ratios(each) for framing, each in counts.items()}
    click.echo(report(found))
    if record:
        settings = {"preset": PRESET, "fields": fields, "keys": list(SCENE), "framings": FRAMINGS}
        write_study_record(record, study_record("framing", settings, found))
