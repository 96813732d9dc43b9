"""`lodbench act`: let the actors of a preset act, and keep what they do as a pose track."""

from pathlib import Path
from typing import Any

import click

from bench.cli.flags import StrictCommand, memory_flag, preset_from_flags, view_flags
from bench.cli.output import Output
from lod.errors import InputError


@click.command("act", cls=StrictCommand)
@view_flags
@memory_flag
@click.option("-o", "folder", required=True, metavar="DIR", help="Folder of the frames to come.")
def command(preset: str, folder: str, max_memory: int | None, out: Output, **flags: Any) -> None:
    """Have the actors act all frames once; `render` into the same folder replays that."""
    from scenes.render.frame_session import prepare_track, read_track, track_path
    from scenes.render.memory import preflight
    from scenes.scene import Scene

    chosen = preset_from_flags(preset, **flags)
    preflight(Scene(chosen), (), max_memory, acted=chosen.acting.frames + 1)
    digest = prepare_track(chosen, folder)
    if digest is None:
        cure = "add a table [actors.NAME], or see docs/actors.md"
        raise InputError("PRESET", preset, "a preset in which somebody acts", cure)
    path = track_path(chosen, Path(folder))
    track = read_track(path)
    assert track is not None
    frames, actors = track.updated.shape
    updates = int(track.updated.sum())
    found = {"frames": frames - 1, "actors": actors, "updates": updates}
    off = float(track.bound_px.max(initial=0.0))
    out.record({"path": str(path), "sha256": digest, **found, "most_off_px": off})
    out.say(f"{path}  {digest[:16]}  {actors} actors, {frames - 1} frames")
    out.say(f"  {updates:,} updates; who coasts is off by {off:.3g} px at most")
