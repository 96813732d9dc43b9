"""A submission: pictures of one pack by one program, as a JSON record, and its page.

A record says who, on which machine, of which pack; for each setting what every repeat took and what
its pictures are worth; and the score. ``timing`` is ``measured`` for what a runner timed from
outside, ``reported`` for seconds that were told.
"""

import hashlib
import json
import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from PIL import Image
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from bench.packs.make import read_pack
from bench.records.provenance import machine
from bench.records.records import content_sha256
from bench.submissions.score import (
    Judged,
    Score,
    Target,
    Timed,
    difference_map,
    judge,
    plain,
    score,
)
from lod.errors import InputError
from scenes.files import whole_file, write_text
from scenes.frame.layers import SKY_Z
from scenes.render.exr.layer_file import read_pixels

FORMAT = 1
STILL = "still"
BASELINE = "blake"
_WALK = re.compile(r"(?:^|\.)(\d{4})$")

SUBMISSIONS = Path(__file__).resolve().parents[2] / "results" / "submissions"

Row = dict[str, Any]


def pack_digest(folder: str | Path) -> str:
    """Return the SHA-256 of what a pack asks for: the same wherever, and by whatever, it is made.

    That is ``pack.json`` to six digits; of references the samples of the still's alone.
    """
    pack = read_pack(Path(folder))
    asked = {k: v for k, v in pack.items() if k not in ("software", "references")}
    asked["spp"] = pack["references"]["still"]["spp"]
    return content_sha256(plain(asked))


def target_of(folder: str | Path, view: str = STILL, variants: bool = False) -> Target:
    """Read a pack's reference of the still, or of a frame of the walk, as ``0001``.

    ``variants`` has the mistakes that need rendering rendered, from the pack's recipe.
    Raises InputError for a view that the pack has no reference of.
    """
    pack = read_pack(Path(folder))
    name = view if view == STILL else f"walk.{view}"
    path = Path(folder) / "reference" / f"{name}.exr"
    if not path.is_file():
        rule, cure = "a view with a reference", "`lodbench pack make --walk` makes those of a walk"
        raise InputError(str(folder), name, rule, cure)
    channels = {k: np.asarray(v, np.float64) for k, v in read_pixels(path)[0].items()}
    whole = _rgb(channels)
    halves = [_rgb(channels, f"{half}.") for half in "ab"] if "a.R" in channels else [whole] * 2
    edges = tuple(map(float, pack["bands_m"]))
    Z = channels["Z"]
    if "cover.0" in channels:
        land = np.stack([channels[f"cover.{k}"] for k in range(len(edges))])
    else:
        band = np.where(Z < SKY_Z, np.digitize(Z, edges[1:]), len(edges))
        land = np.stack([(band == k).astype(np.float64) for k in range(len(edges))])
    shares = np.concatenate([land, 1 - land.sum(axis=0, keepdims=True)])
    found = dict(_neighbours(Path(folder), view, whole.shape))
    if variants:
        from bench.submissions.mistakes import rendered_mistakes

        number = 1 if view == STILL else int(view)
        recipe = json.loads((Path(folder) / "recipe.json").read_text(encoding="utf-8"))
        found |= rendered_mistakes(recipe, number, (whole.shape[1], whole.shape[0]))
    one, two = halves
    return Target((one, two), Z, shares, (*edges, float(SKY_Z)), found)


def _rgb(channels: Mapping[str, np.ndarray], lead: str = "") -> np.ndarray:
    return np.stack([channels[f"{lead}{c}"] for c in "RGB"], axis=2)


def _neighbours(folder: Path, view: str, shape: tuple[int, ...]) -> list[tuple[str, np.ndarray]]:
    """Read the frames before and after one of the walk."""
    found = []
    for step, name in ((-1, "one frame early"), (1, "one frame late")) if view != STILL else ():
        path = folder / "reference" / f"walk.{int(view) + step:04d}.exr"
        if path.is_file():
            picture = _rgb(read_pixels(path)[0]).astype(np.float64)
            if picture.shape == shape:
                found.append((name, picture))
    return found


def views_of(paths: Sequence[str | Path]) -> dict[str, Path]:
    """Tell which view each file shows: ``NAME.0001.exr`` a frame of the walk, others the still.

    Raises InputError for two files of one view, and for none.
    """
    found: dict[str, Path] = {}
    for path in map(Path, paths):
        match = _WALK.search(path.stem)
        view = match[1] if match else STILL
        if view in found:
            raise InputError(str(path), view, f"one picture of a view; {found[view]} is another")
        found[view] = path
    if not found:
        raise InputError("EXR", "none", "at least one picture", "try DIR/still.exr")
    return found


def judged(paths: Sequence[str | Path], pack: str | Path, variants: bool) -> dict[str, Judged]:
    """Judge pictures of one setting, by view; mistakes are rendered only where they may explain."""
    found = {}
    for view, path in views_of(paths).items():
        target = target_of(pack, view)
        here = judge(path, target)
        if variants and not here.cause and (here.void or here.flip > 1.2 * here.floor):
            here = judge(path, target_of(pack, view, variants=True))
        found[view] = here
    return found


def setting_row(
    setting: float, pictures: Mapping[str, Judged], runs: Sequence[Row], files: Sequence[Path]
) -> Row:
    """Return what a record says of one setting; ``runs`` have seconds and more of each repeat."""
    return {
        "setting": setting,
        "runs": list(runs),
        "pictures": {view: each.as_json() for view, each in pictures.items()},
        "sha256": {p.name: hashlib.sha256(p.read_bytes()).hexdigest() for p in files},
    }


def record_of(
    pack: str | Path,
    who: str,
    program: str,
    timing: str,
    rows: Sequence[Row],
    baseline: Row | None,
    command: str = "",
) -> Row:
    """Return the record of a submission, with its score beside the published baseline.

    A program named ``blake`` is the baseline, and its own record is what it is held against.
    """
    itself = {"program": program, "settings": rows} if program.split()[:1] == [BASELINE] else None
    found = scored(rows, itself or baseline)
    return {
        "format": FORMAT,
        "what": "a submission to lodbench",
        "pack": read_pack(Path(pack))["pack"],
        "pack_sha256": pack_digest(pack),
        "who": who,
        "program": program,
        "command": command,
        "date": datetime.now(UTC).strftime("%Y-%m-%d"),
        "machine": machine(),
        "timing": timing,
        "settings": list(rows),
        "score": plain(found.ratio),
        "told": found.told,
    }


def scored(rows: Sequence[Row], baseline: Row | None) -> Score:
    """Score settings beside a baseline's record; NaN where there is none."""
    if baseline is None:
        return replace(score(_timed(rows), math.inf, 1.0), ratio=math.nan, told="no baseline")
    row = next((each for each in baseline["settings"] if each["setting"] == 1), None)
    if row is None:
        raise InputError("--baseline", baseline["program"], "a record with a setting of 1 px")
    (here,) = _timed([row])
    return score(_timed(rows), here.flip, here.seconds)


def _timed(rows: Sequence[Row]) -> list[Timed]:
    """Read errors and seconds of settings: means over views, medians over repeats."""
    found = []
    for row in rows:
        pictures = row["pictures"].values()
        flips = [math.nan if p["flip"] is None else p["flip"] for p in pictures]
        seconds = [run["seconds"] for run in row["runs"] if run.get("seconds") is not None]
        counts = not any(p["void"] for p in pictures)
        taken = float(np.median(seconds)) if seconds else math.nan
        found.append(Timed(float(np.mean(flips)), counts, taken))
    return found


def published_baseline(pack: str | Path, path: str | None = None) -> Row | None:
    """Read the record of ``blake`` on a pack: the one named, or that of results/submissions.

    None where none is published. Raises InputError for one of another pack.
    """
    if path is None:
        usual = SUBMISSIONS / f"{BASELINE}-{read_pack(Path(pack))['pack']}.json"
        if not usual.is_file() or read_submission(usual)["pack_sha256"] != pack_digest(pack):
            return None
        path = str(usual)
    found = read_submission(path, "--baseline")
    if found["pack_sha256"] != pack_digest(pack):
        raise InputError("--baseline", path, "a record of the very same pack")
    return found


class _Open(BaseModel):
    model_config = ConfigDict(extra="allow", strict=True, allow_inf_nan=False)


class _Picture(_Open):
    void: str
    flip: float | None
    land: float | None
    coverage: float | None


class _Run(_Open):
    seconds: float | None = None
    cpu_seconds: float | None = None
    peak_bytes: float | None = None


class _Setting(_Open):
    setting: float
    runs: list[_Run]
    pictures: dict[str, _Picture]
    sha256: dict[str, str]


class _Machine(_Open):
    cpu: str
    cores: int
    load: float | None = None


class _Record(_Open):
    """What of a record is asked for again, whoever wrote it."""

    format: Literal[1]
    pack: str
    pack_sha256: str
    who: str
    program: Annotated[str, Field(pattern=r"\S")]
    date: str
    timing: str
    told: str
    score: Annotated[float, Field(gt=0)] | None
    machine: _Machine
    settings: Annotated[list[_Setting], Field(min_length=1)]


def read_submission(path: str | Path, where: str = "submission") -> Row:
    """Read a record. Raises InputError for what is none."""
    try:
        found: Row = json.loads(Path(path).read_text(encoding="utf-8"))
        _Record.model_validate(found)
    except ValidationError as error:
        at = ".".join(map(str, error.errors()[0]["loc"]))
        rule = f"a record that `lodbench score` wrote ({at}: {error.errors()[0]['msg']})"
        raise InputError(where, str(path), rule, "score the pictures again") from None
    except (OSError, ValueError, RecursionError) as error:
        rule = f"a record that `lodbench score` wrote ({error})"
        raise InputError(where, str(path), rule, "score the pictures again") from None
    return found


def check_again(record: Row, paths: Sequence[str | Path], pack: str | Path) -> list[str]:
    """Judge pictures once more, and say where a record says otherwise; nothing where it is true.

    Raises InputError for a record of another pack.
    """
    if record["pack_sha256"] != pack_digest(pack):
        raise InputError("--check", record["pack"], f"a record of {pack}")
    found = []
    for view, each in judged(paths, pack, variants=False).items():
        path = views_of(paths)[view]
        digest = hashlib.sha256(path.read_bytes()).hexdigest()
        rows = [r for r in record["settings"] if r["sha256"].get(path.name) == digest]
        if not rows:
            found.append(f"{path.name}: the record has no such picture")
            continue
        said, here = rows[0]["pictures"][view], each.as_json()
        for name in ("flip", "land", "coverage"):
            if (said[name] is None) != (here[name] is None) or not math.isclose(
                said[name] or 0, here[name] or 0, rel_tol=1e-4
            ):
                found.append(f"{path.name}: {name} is {here[name]}, the record says {said[name]}")
        if bool(said["void"]) != bool(here["void"]):
            found.append(f"{path.name}: {here['void'] or 'valid'}, the record says otherwise")
    return found


def write_record(folder: Path, record: Row, paths: Sequence[str | Path], pack: Path) -> Path:
    """Write ``submission.json``, a page ``score.md``, and a map of differences for each view."""
    path = folder / "submission.json"
    write_text(path, json.dumps(record, indent=1, allow_nan=False) + "\n")
    for view, file in views_of(paths).items():
        channels = {k: np.asarray(v, np.float64) for k, v in read_pixels(file)[0].items()}
        shown = np.rint(255 * difference_map(_rgb(channels), target_of(pack, view)))
        with whole_file(folder / f"difference-{view}.png", overwrite=True) as temporary:
            Image.fromarray(shown.astype(np.uint8)).save(temporary, "PNG")
    write_text(folder / "score.md", page(record))
    return path


def page(record: Row) -> str:
    """Write a record for people, as Markdown."""
    value = "–" if record["score"] is None else f"{record['score']:.3g}"
    told = f" ({record['told']})" if record["told"] else ""
    lines = [
        f"# {record['program']} on {record['pack']}",
        f"By {record['who']}, {record['date']}, on {record['machine']['cpu']} with "
        f"{record['machine']['cores']} cores. Times are {record['timing']}.",
        f"**Time to the error of `blake` at one pixel, ÷ the baseline's: {value}**{told}",
        "FLIP is the mean to the reference; its floor is that of the reference to itself. A band's "
        "luminance and coverage are divided by the reference's.",
    ]
    for row in record["settings"]:
        for view, each in row["pictures"].items():
            seconds = ", ".join(f"{r['seconds']:.3g}" for r in row["runs"] if r.get("seconds"))
            lines.append(f"## Setting {row['setting']:g}, {view}")
            lines.append(f"{'**void**: ' + each['void'] if each['void'] else 'valid'}")
            if each["cause"]:
                lines.append(f"{each['cause']}: explains {each['explains']:.0%} of the difference")
            cells = [
                (b["name"], *(_number(b[k]) for k in ("share", "luminance", "coverage", "kept")))
                for b in each["bands"]
            ]
            land = "land", "", _number(each["land"]), _number(each["coverage"]), ""
            heads = "band", "share", "luminance", "coverage", "structure kept"
            table = [heads, ["---"] * 5, *cells, land]
            lines.append("\n".join(f"| {' | '.join(row)} |" for row in table))
            lines.append(
                f"FLIP {_number(each['flip'])}, floor {_number(each['floor'])}; "
                f"seconds {seconds or 'not told'}. ![FLIP by pixel](difference-{view}.png)"
            )
    return "\n\n".join(lines) + "\n"


def _number(value: float | None) -> str:
    return "–" if value is None else f"{value:.4f}"
