"""Render the pairs of an experiment, ask models about them, and write the page.

The name of a picture is a digest of all that made it: the same command goes on where it was
stopped, and nobody reads from a name what is pruned. The two pictures of the reference, and those
of the levels, have samples of their own, so that grain tells nothing.

Three models look at every pair, as it is displayed at 60 pixels a degree:

flip     mean FLIP (``bench.images.differences``); of clips that of first, middle and last frame
barten   contrast in thresholds of Barten's eye (``lod.eye``): parts of τ px are half-periods of a
         frequency f, and √2 times the RMS of (Y − Y′)/mean Y′ in the octave about f is the
         modulation of a grating with as much contrast; times the eye's sensitivity at f it is 1
         where the eye sees it half of the time, and so is right three times in four
lost     JOD below ten of ColorVideoVDP, where its environment is there

What the second picture of the reference has of FLIP and of squared contrast is grain's alone, and
is taken away.
"""

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from bench.experiment import Progress
from bench.images.differences import mean_flip
from bench.methods.environments import VIDEO
from bench.methods.video import just_objectionable_differences
from bench.observers import plan
from bench.observers.plan import LEVELS_PX, STAIRCASE, Condition, block_of
from bench.observers.psychometric import GUESS
from bench.observers.results import FORMAT, FORMAT_VERSION
from bench.records.records import content_sha256
from bench.runs import CaseExecutor, sources, spent_since
from lod.eye import SQUARE_WAVE_GAIN, Display, Eye, sensitivity
from scenes.files import write_text
from scenes.presets.load import Setting, load_preset
from scenes.presets.schema import Preset
from scenes.render import pictures
from scenes.render.pictures import auto_exposure, to_srgb_8bit
from scenes.render.render import build_frame, trace
from scenes.render.variants import choose
from scenes.scene import Scene
from scenes.sticks.prototype import LUMINANCE

PLAN, PAGE, PICTURES = "plan.json", "index.html", "pictures"
APART = "sha256", "models", "power", "seconds"  # what of a plan the page does not show

OBSERVERS, BREAK_EVERY = 120, 42
"""Numbers that have blocks of their own, before these come again; trials between breaks."""

SECONDS = 1.5, 0.75
"""Processor seconds of a frame that is built, and of each million samples (see the page)."""


@dataclass(frozen=True)
class Pictures:
    """How the pictures of an experiment are made: size WxH, samples a pixel, frames of a clip."""

    size: str = "576x324"
    spp: int = 256
    frames: int = 24

    def estimated_seconds(self, conditions: Sequence[Condition]) -> float:
        """Estimate the processor seconds in which all is rendered."""
        frames = sum(self.frames if each.moving else 1 for each in conditions) * (len(VERSIONS) + 1)
        samples = math.prod(map(int, self.size.split("x"))) * self.spp
        return frames * (SECONDS[0] + SECONDS[1] * samples / 1e6)

    def preset(self, condition: Condition, detail_px: float) -> Preset:
        """Return the preset of a condition at a detail [px]."""
        own = {"render.size": self.size, "render.spp": self.spp, "view.detail": detail_px}
        own["camera.fps"] = float(plan.FPS)
        laid = {**plan.PLACES[condition.place], **plan.WAYS[condition.way], **own}
        flags = {"render.size": "--size", "render.spp": "--spp"}
        settings = [Setting(flags.get(key, key), key, value) for key, value in laid.items()]
        return load_preset(plan.SUBJECTS[condition.subject], settings)


Version = tuple[float, int]
"""One picture or clip of a condition: its τ [px], and which samples it has."""

REFERENCE: Version = (plan.REFERENCE_PX, 0)
VERSIONS: tuple[Version, ...] = (
    (plan.REFERENCE_PX, 1),
    *((px, 2) for px in (*LEVELS_PX, plan.CATCH_PX)),
)


def make_condition(condition: Condition, folder: Path, how: Pictures) -> dict[str, Any]:
    """Render what is left of a condition, and return its entry of the plan."""
    numbers = range(1, (how.frames if condition.moving else 1) + 1)
    variant = choose()
    made_by = [condition, asdict(how), variant, sources()]
    ends = ".webm" if condition.moving else ".png"

    def path(version: Version) -> Path:
        return folder / PICTURES / f"{content_sha256([version, *made_by])[:24]}{ends}"

    def said(version: Version) -> Path:
        return path(version).with_suffix(".json")

    left = [each for each in VERSIONS if not (path(each).exists() and said(each).exists())]
    if left or not path(REFERENCE).exists():
        start = spent_since().values()
        scene = Scene(how.preset(condition, plan.REFERENCE_PX))
        radiance = list(radiances(scene, numbers, variant, REFERENCE[1]))
        exposure = auto_exposure(radiance[0])
        whole = [to_srgb_8bit(each, exposure) for each in radiance]
        write_clip(whole, path(REFERENCE))
        for version in left:
            here = scene.with_preset(how.preset(condition, version[0]))
            rendered = radiances(here, numbers, variant, version[1])
            shown = [to_srgb_8bit(each, exposure) for each in rendered]
            write_clip(shown, path(version))
            spent = spent_since([*start])
            write_text(said(version), json.dumps(look_at(shown, whole) | {"spent": spent}))
            start = spent_since().values()
    grain, *levels = (json.loads(said(each).read_text("utf-8")) for each in VERSIONS)
    reference, again, *files = (f"{PICTURES}/{path(v).name}" for v in (REFERENCE, *VERSIONS))
    shown_at = {"reference": reference, "again": again, "levels": files}
    about = {"name": condition.name, "moving": condition.moving}
    seconds = sum(each["spent"]["processor_seconds"] for each in (grain, *levels))
    return about | shown_at | {"models": without_grain(levels, grain), "seconds": seconds}


def radiances(
    scene: Scene, numbers: Sequence[int], variant: str, samples: int
) -> Iterator[np.ndarray]:
    """Render frames of a scene, whose samples are the n-th of their own."""
    for number in numbers:
        frame_input = scene.input(number, variant)
        quality = frame_input.quality
        own = replace(quality, seed=quality.seed + 1000 * samples)
        yield trace(build_frame(frame_input), own, number).rgb


def write_clip(shown: Sequence[np.ndarray], path: Path) -> None:
    """Write displayed pictures as a PNG or a film, as the path ends."""
    path.parent.mkdir(exist_ok=True)
    if path.suffix == ".png":
        pictures.save_picture(Image.fromarray(shown[0]), path)
    else:
        pictures.encode_movie(iter(shown), path, plan.FPS, pictures.NEARLY_LOSSLESS)


def look_at(shown: Sequence[np.ndarray], whole: Sequence[np.ndarray]) -> dict[str, Any]:
    """Return what models say of pictures beside a reference; contrasts in each level's band."""
    some = sorted({0, len(shown) // 2, len(shown) - 1})
    pairs = [[each[k].astype(np.float32) / 255 for each in (shown, whole)] for k in some]
    flips = [mean_flip(one, other, plan.PIXELS_PER_DEGREE) for one, other in pairs]
    contrasts = np.mean([band_contrasts(one, other) for one, other in pairs], axis=0)
    said = {"flip": [float(np.mean(flips))], "barten": contrasts.tolist()}
    if VIDEO.python():
        one, other = (np.stack(each).astype(np.float32) / 255 for each in (shown, whole))
        at = plan.FPS, [plan.PIXELS_PER_DEGREE]
        said["lost"] = [10 - just_objectionable_differences({"it": one}, other, *at)["it"][0]]
    return said


def band_contrasts(
    shown: np.ndarray, whole: np.ndarray, ppd: float = plan.PIXELS_PER_DEGREE
) -> np.ndarray:
    """Return the difference of two displayed pictures in thresholds of Barten's eye, by level."""
    from colour.models import eotf_sRGB

    one, other = (eotf_sRGB(each.astype(np.float64)) @ LUMINANCE for each in (shown, whole))
    power = np.abs(np.fft.fft2((one - other) / other.mean()) / one.size) ** 2
    down, across = (ppd * np.fft.fftfreq(n) for n in one.shape)
    frequency = np.hypot(down[:, None], across)
    eye = sensitivity(Display(ppd, field_deg=math.sqrt(one.size) / ppd), Eye())
    found = []
    for px in LEVELS_PX:
        f = ppd / (2 * px)
        within = (frequency >= f / math.sqrt(2)) & (frequency < f * math.sqrt(2))
        gain = np.interp(f, eye.frequency, eye.value / SQUARE_WAVE_GAIN, right=0.0)
        found.append(gain * math.sqrt(2 * power[within].sum()))
    return np.array(found)


def without_grain(levels: Sequence[Mapping[str, Any]], grain: Mapping[str, Any]) -> dict[str, Any]:
    """Return each model's value of every level of the staircase, less that of grain."""
    own = levels[: len(LEVELS_PX)]
    contrasts = np.array([each["barten"][k] for k, each in enumerate(own)])
    values = {
        "flip": [each["flip"][0] - grain["flip"][0] for each in own],
        "barten": beyond_grain(contrasts, np.array(grain["barten"])).tolist(),
    }
    lost = [each["lost"][0] for each in own if "lost" in each]
    return values | ({"lost": lost} if len(lost) == len(own) else {})


def beyond_grain(contrasts: np.ndarray, grain: np.ndarray) -> np.ndarray:
    """Take the contrasts of grain from others, both (n,): variances add up."""
    return np.sqrt(np.maximum(contrasts**2 - grain**2, 0.0))


def plan_body(whole: Mapping[str, Any]) -> dict[str, Any]:
    """Return what of a plan the page shows, and its digest is of."""
    return {key: v for key, v in whole.items() if key not in APART}


def make(
    folder: Path,
    conditions: Sequence[Condition],
    how: Pictures,
    executor: CaseExecutor,
    progress: Progress,
    power: Sequence[Mapping[str, float]],
) -> dict[str, Any]:
    """Make an experiment in a folder: its pictures, its plan and its page; return the plan."""
    (folder / PICTURES).mkdir(exist_ok=True)
    made, entries = executor(make_condition, [(each, folder, how) for each in conditions]), []
    for number, condition in enumerate(conditions):
        progress(number, len(conditions), condition.name)
        entries.append(next(made))
    progress(len(conditions), len(conditions), "page")
    blocks = [block_of(k + 1, conditions) for k in range(OBSERVERS)]
    whole: dict[str, Any] = {
        "format": FORMAT,
        "format_version": FORMAT_VERSION,
        "seed": 1,
        "size": [int(each) for each in how.size.split("x")],
        "spp": how.spp,
        "frames": how.frames,
        "fps": plan.FPS,
        "pixels_per_degree": plan.PIXELS_PER_DEGREE,
        "trials": plan.TRIALS,
        "catches": plan.CATCHES,
        "block_trials": len(blocks[0]) * (plan.TRIALS + plan.CATCHES),
        "break_every": BREAK_EVERY,
        "staircase": asdict(STAIRCASE) | {"guess": GUESS},
        "models": {each["name"]: each.pop("models") for each in entries},
        "seconds": {each["name"]: each.pop("seconds") for each in entries},
        "power": power,
        "blocks": blocks,
        "conditions": entries,
    }
    whole["sha256"] = content_sha256(plan_body(whole))
    write_text(folder / PLAN, json.dumps(whole, indent=1, ensure_ascii=False) + "\n")
    write_text(folder / PAGE, page({**plan_body(whole), "sha256": whole["sha256"]}))
    return whole


def page(body: Mapping[str, Any]) -> str:
    """Return the page of a plan, with all that it runs inside it."""
    shelf = resources.files("bench.observers") / "page"
    text = (shelf / "page.html").read_text("utf-8")
    for name in ("jspsych/LICENSE", "jspsych/jspsych.js", "page.css", "quest.js", "page.js"):
        text = text.replace(f"/*{name}*/", (shelf / name).read_text("utf-8"))
    told = json.dumps(body, ensure_ascii=False).replace("<", "\\u003c")
    return text.replace("/*plan*/", told)
