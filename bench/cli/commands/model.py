"""`lodbench model`: other people's models as species of a field."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
import numpy as np

from bench.cli.flag_rules import StrictCommand
from bench.cli.output import Output, output, table

if TYPE_CHECKING:
    from scenes.imported.part_tree import PartTree

_json = click.option("--json", "as_json", is_flag=True, help="One JSON object on stdout.")
_sheet = click.option(
    "-o", "sheet", metavar="SHEET.png", help="Where a picture of every level goes."
)


@click.group("model")
def command() -> None:
    """Bring models of your own: USD or glTF scenes whose node tree is the part hierarchy."""


@command.command("add", cls=StrictCommand)
@click.argument("file", metavar="FILE")
@click.option("--name", metavar="NAME", help="What presets call it; by default as the file.")
@click.option("--overwrite", is_flag=True, help="Replace a model of that name.")
@_sheet
@_json
def add(file: str, name: str | None, overwrite: bool, sheet: str | None, as_json: bool) -> None:
    """Read and check a .usd, .usda, .usdc, .usdz, .gltf or .glb file, and keep it as a model."""
    from scenes.imported.library import keep_model, read_model

    with output(as_json) as out:
        tree = read_model(Path(file))
        called = name or Path(file).stem
        path = keep_model(called, tree, overwrite)
        _tell(out, called, tree)
        _picture(out, called, tree, Path(sheet) if sheet else path.with_suffix(".png"))
        out.note(f"{path} holds it: a preset's species has it by model = {called!r}")


@command.command("list", cls=StrictCommand)
@_json
def list_models(as_json: bool) -> None:
    """Models that were added, a line each."""
    from scenes.imported.library import user_model
    from scenes.model_files.names import models_folder, user_model_names

    with output(as_json) as out:
        found = {name: _facts(user_model(name)) for name in user_model_names()}
        out.record({"models": found})
        rows = [
            (name, each["parts"], each["levels"], each["triangles"], each["height_m"])
            for name, each in found.items()
        ]
        if rows:
            out.say(table([("model", "parts", "levels", "triangles", "height [m]"), *rows]))
        else:
            out.say(f"none in {models_folder()}: `lodbench model add FILE` adds one")


@command.command("show", cls=StrictCommand)
@click.argument("model", metavar="NAME|FILE")
@_sheet
@_json
def show(model: str, sheet: str | None, as_json: bool) -> None:
    """What a model holds, level by level; a file is read and checked, and not kept."""
    from scenes.imported.library import read_model, user_model
    from scenes.model_files.names import is_model_file

    with output(as_json) as out:
        is_file = is_model_file(model) or "/" in model
        tree = read_model(Path(model)) if is_file else user_model(model)
        _tell(out, model, tree)
        if sheet:
            _picture(out, model, tree, Path(sheet))


@command.command("remove", cls=StrictCommand)
@click.argument("name", metavar="NAME")
@_json
def remove(name: str, as_json: bool) -> None:
    """Remove a model that was added; presets that name it are refused from then on."""
    from scenes.imported.library import remove_model

    with output(as_json) as out:
        remove_model(name)
        out.record({"removed": name})
        out.say(f"{name} is removed")


def _picture(out: Output, name: str, tree: "PartTree", path: Path) -> None:
    """Write the contact sheet of a model's levels."""
    from bench.cli.model_sheet import model_sheet
    from scenes.imported.imported_prototype import imported_prototype
    from scenes.render.variants import choose

    out.note(
        f"{model_sheet(imported_prototype(name, tree), path, choose('auto'))} shows its levels"
    )


def _facts(tree: "PartTree") -> dict[str, Any]:
    """What there is to know of a model, as plain data."""
    low, high = tree.meshes.vertices.min(axis=0), tree.meshes.vertices.max(axis=0)
    return {
        "sha256": tree.digest,
        "parts": len(tree),
        "levels": int(tree.level.max()) + 1,
        "triangles": len(tree.meshes),
        "height_m": float(high[2]),
        "low_m": low.tolist(),
        "high_m": high.tolist(),
        "turns": tree.turning,
    }


def _tell(out: Output, name: str, tree: "PartTree") -> None:
    """Print what a model holds, and its levels with a part of each."""
    facts = _facts(tree)
    parts = np.bincount(tree.level)
    triangles = np.bincount(tree.level, tree.meshes.count).astype(int)
    levels = [
        {"level": level, "parts": int(n), "triangles": int(triangles[level])}
        for level, n in enumerate(parts.tolist())
    ]
    out.record({"model": name, **facts, "by_level": levels})
    size = " by ".join(f"{x:.3g}" for x in np.subtract(facts["high_m"], facts["low_m"]))
    lead = f"{name}: {facts['parts']:,} parts, {facts['triangles']:,} triangles, {size} m"
    bottom = f"lowest point {facts['low_m'][2]:.3g} m above the ground"
    rows: list[tuple[Any, ...]] = [("level", "parts", "triangles", "such as")]
    for each in levels:
        rows += [
            (each["level"], each["parts"], each["triangles"], tree.names[row])
            for row in np.flatnonzero(tree.level == each["level"])[:1].tolist()
        ]
    out.say(f"{lead}, {bottom}\n{table(rows)}\n  sha256 {facts['sha256']}")
