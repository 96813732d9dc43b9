"""Clips, pruned beside everything drawn, and what motion does not explain of both."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from click.testing import CliRunner

from bench.experiments.popping import unexplained_change as popping_measure
from bench.experiments.popping.unexplained_change import Walk, frames_of, popped
from bench.studies.films import clips
from bench.studies.films.clips import CLIPS, WAYS, pixels_seen_before, table_rows, verdict_line
from lod.camera import Corner, camera_from_heading
from scenes.presets.load import load_preset
from scenes.render.exr.layers import read_exr
from scenes.scene import assemble_frame, view_at
from scenes.world.world import build_world


@pytest.mark.parametrize("name", list(CLIPS))
@pytest.mark.parametrize("way", list(WAYS))
def test_every_clip_is_a_preset(name, way):
    preset = load_preset("meadow", (*clips.WORLD, *CLIPS[name], *WAYS[way]))
    assert (preset.view.metric == "full") == (way == "everything")


def stopping():
    """The clip, of people alone on bare ground, and small."""
    people = ("species.tree.density=0", "species.figure.prototypes=1", "render.size=160x90")
    words = (*clips.WORLD, *CLIPS["stop"], *people, "species.figure.density=0.02")
    preset = load_preset("meadow", words)
    world = build_world(preset)
    return replace(world, terrain=replace(world.terrain, aggregate_cover=None)), preset


def pops(numbers):
    world, preset = stopping()
    return [popped(*both) for both in pairwise(frames_of(world, (preset,), numbers))]


def test_nothing_comes_at_full_size_when_the_camera_stops(monkeypatch):
    """Where nothing eases what the turn hides, hundreds of parts come in the frame of the stop."""
    numbers = range(15, 18)
    assert pops(numbers) == [0, 0]

    def not_eased(*shot):
        view = view_at(*shot)
        return replace(view, shutter=replace(view.shutter, neighbour=None))

    monkeypatch.setattr(popping_measure, "view_at", not_eased)
    assert max(pops(numbers)) > 200


def test_a_frame_of_a_stop_alone_is_that_of_the_sequence():
    world, preset = stopping()
    for number in (14, 15, 16):
        after = assemble_frame(world, preset, number, "scalar_rgb")
    alone = assemble_frame(world, preset, 16, "scalar_rgb")
    for one, other in zip(after.displayed, alone.displayed, strict=True):
        assert np.array_equal(one.cut.part, other.cut.part)
        a, b = (next(iter(vars(each.shape).values())) for each in (one, other))
        assert len(a) and a.tobytes() == b.tobytes()


def camera(heading):
    return camera_from_heading(Corner(0, 0), np.zeros(3), heading, 0.0, 60.0, (64, 36))


def test_what_a_turn_brings_into_view_is_told_from_what_was_seen():
    """30° to the right of 60°: what was right of the middle is now left of it."""
    known = pixels_seen_before(camera(0.0), camera(30.0))
    assert known[18, :31].all() and not known[18, 33:].any()
    assert pixels_seen_before(camera(0.0), camera(0.0)).all()
    assert not pixels_seen_before(camera(0.0), camera(180.0)).any()


def test_a_clip_is_judged_against_everything_and_the_planted_one_beside_it():
    def left(value):
        residual = np.full((2, 4, 4), value)
        return Walk(np.ones(2, int), residual, residual / 2, residual)

    found = {"pruned": left(0.05), "everything": left(0.1), "planted": left(0.3)}
    assert verdict_line("pan", found) == (
        "pan: pruned 0.50, planted 3.00 of what everything drawn has; within 1.1; "
        "parts popped: pruned 2, everything 2, planted 2"
    )
    assert verdict_line("pan", {**found, "pruned": left(0.12)}).count("beyond 1.1") == 1
    assert "proves nothing" in verdict_line("pan", {**found, "planted": left(0.11)})
    assert len(table_rows("pan", found, 1)) == 2
    assert table_rows("pan", found, 1)[0] == (
        "pan",
        2,
        "0.0500",
        "0.0250",
        "0.1000",
        "0.0500",
        "0.3000",
        "0.1500",
    )


def test_frames_to_measure_are_two_or_more(tmp_path):
    words = ["-o", str(tmp_path), "--measure", "5", "5"]
    told = CliRunner().invoke(clips.command, words)
    assert told.exit_code == 2 and "--measure 5 5" in told.output


@pytest.mark.slow
def test_a_clip_lies_side_by_side_on_disk_and_has_its_rows(tmp_path):
    words = ["-o", str(tmp_path), "--frames", "2", "--size", "48x27", "--spp", "8"]
    words += ["--measure-size", "48x27"]
    told = CliRunner().invoke(clips.command, [*words, "--clip", "pan"])
    assert told.exit_code == 0, told.output
    assert "everything" in told.output
    assert {"pan.png", "pan.0001.exr", "pan.0002.exr"} <= {p.name for p in tmp_path.iterdir()}
    shown = read_exr(tmp_path / "pan.0001.exr")[0].rgb
    assert shown.shape == (27, 96, 3)
    assert np.abs(shown[:, :48] - shown[:, 48:]).mean() < 0.1 * shown.mean()
