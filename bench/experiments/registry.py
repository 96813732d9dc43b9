"""The experiments, by name. What one needs is imported when it is used: listing them is fast."""

import importlib
from typing import Any

from bench.runner.experiment import Experiment


def _later(module: str, name: str) -> Any:
    """A function of a module that is imported when it is first called."""

    def call(*args: Any, **named: Any) -> Any:
        return getattr(importlib.import_module(f"bench.{module}"), name)(*args, **named)

    return call


def _judge(module: str) -> Any:
    """The module's judge of points, asked for those of a record."""
    judge = _later(module, "judge")
    return lambda record: judge(record.points)


EXPERIMENTS: dict[str, Experiment] = {
    "scaling": Experiment(
        about="objects and parts against K(P+R)²/m², prefactor and all; and where that breaks",
        question="Does the number of things in a frame depend on what the viewer can resolve, "
        "and not on the size of the world?",
        run=_later("experiments.scaling.measure", "run"),
        plots=_later("experiments.scaling.plots", "plots"),
        point_table=_later("experiments.scaling.plots", "table"),
        judge=_judge("experiments.scaling.claims"),
        accepts_metric=True,
        caveats=(
            "An eye that looks all round; a field of view has predictions of its own (`lodbench "
            "count`).",
            "Hills of one shape, patches of one kind, haze of one visibility: they show where the "
            "bare law breaks, and that the law with its terms does not.",
            "Counts, not seconds: what a frame costs is another experiment.",
        ),
        expected_seconds=(40.0, 260.0),
    ),
    "figure": Experiment(
        about="parts of one object against distance and level, and what posing it costs",
        question="Do the parts of a figure drop off with the square root of its distance?",
        run=_later("experiments.figure.measure", "run"),
        plots=_later("experiments.figure.plots", "plots"),
        point_table=_later("experiments.figure.plots", "table"),
        judge=_later("experiments.figure.claims", "judge_record"),
        accepts_metric=True,
        caveats=(
            "One person and one of each kind, as tables made them: intervals are over poses, "
            "directions and places in the grid of distances, not over other people or animals.",
            "An exponent is that of the straight line nearest to a curve which is not straight: "
            "its nearer and farther halves stand in the table of points.",
            "Times are those of one machine, its compiler and these two kernels; they say which "
            "is cheaper here.",
        ),
        expected_seconds=(5.0, 10.0),
    ),
    "haze": Experiment(
        about="what haze takes of each size of part, from V = 0.5 to 50 km, measured and predicted",
        question="Which parts does haze hide, and does the law know how many?",
        run=_later("experiments.haze.measure", "run"),
        plots=_later("experiments.haze.plots", "plots"),
        point_table=_later("experiments.haze.plots", "table"),
        judge=_judge("experiments.haze.claims"),
        caveats=(
            "Flat ground and an eye 1.6 m up that looks all round; nothing hides anything.",
            "What is gone is what Barten's standard observer could not see on a display of 100 "
            "cd/m²; a tone curve that steepens contrast shows more.",
            "Shares depend on m·V alone, as long as contrast classes are the same: a finer picture "
            "shows more far parts for haze to take.",
        ),
        expected_seconds=(60.0, 150.0),
    ),
    "eye": Experiment(
        about="what display and eye leave out, from 20 to 120 pixels per degree",
        question="How much detail is lost on the eye, by blur and by contrast?",
        run=_later("experiments.eye.measure", "run"),
        plots=_later("experiments.eye.plots", "plots"),
        point_table=_later("experiments.eye.plots", "table"),
        judge=_judge("experiments.eye.claims"),
        caveats=(
            "Clear air, flat ground, a picture that stays 640 pixels wide.",
            "One standard observer, 20 to 30 years old, on a display of 100 cd/m² and 53°.",
            "A part is a half-period of a grating of its own size; what eyes make of edges, colour "
            "and movement is not in it.",
        ),
        expected_seconds=(30.0, 300.0),
    ),
    "colonnade": Experiment(
        about="Leonardo's columns: solid angle against image size, true distance against depth",
        question="Does true distance take detail from where it is seen least?",
        run=_later("experiments.colonnade.measure", "run"),
        plots=_later("experiments.colonnade.plots", "plots"),
        point_table=_later("experiments.colonnade.plots", "table"),
        judge=_judge("experiments.colonnade.claims"),
        caveats=(
            "One row of one kind of column, looked at from one place with a wide view.",
            "Errors at the eye are those of an eye at the centre of projection; who stands "
            "elsewhere sees the error in the image.",
            "Depth is the coarser the finer it is asked to be: its cut with about as many parts is "
            "the nearest that there is.",
        ),
        expected_seconds=(60.0, 120.0),
    ),
    "air": Experiment(
        about="haze as rendered: targets, the medium that scatters light, and spectral light",
        question="Is the haze in the pictures what theory, a scattering medium and light of "
        "sixteen bands make of it?",
        run=_later("experiments.air.measure", "run"),
        plots=_later("experiments.air.plots", "plots"),
        point_table=_later("experiments.air.plots", "table"),
        judge=_judge("experiments.air.claims"),
        caveats=(
            "The airlight of the horizon's sky leaves out which way the sun stands to the air, "
            "that its glow varies with height, that it lies in the shade of what stands in it, and "
            "that it dims the light on its way to the ground. The scattered one has all that, with "
            "the shade of the mean stand, over ground that is level where a line of sight passes.",
            "The medium is a layer 10 m higher than the scene, under a sky that holds a whole "
            "atmosphere already; its phase function is one of clean continental air.",
            "RGB and spectral pictures also differ in the coefficients of the sky's model: the "
            "row of the sky shows by how much.",
        ),
        expected_seconds=(80.0, 145.0),
    ),
    "fidelity": Experiment(
        about="image error against parts, memory and time, every metric, τ from ⅛ to 8 pixels",
        question="What does pruning do to the picture, and which metric does least for its parts?",
        run=_later("experiments.fidelity.measure", "run"),
        plots=_later("experiments.fidelity.plots", "plots"),
        point_table=_later("experiments.fidelity.plots", "table"),
        judge=_judge("experiments.fidelity.claims"),
        summary=_later("experiments.fidelity.plots", "summary"),
        accepts_metric=True,
        expected_seconds=(120.0, 900.0),
        caveats=(
            "One meadow in a window 240 m wide, in three views of 64×36 pixels: pixels are large, "
            "and so are the limits that they set; what lies beyond 170 m is not there at all.",
            "FLIP is of one exposure and 67 pixels per degree; more of either shows more.",
            "Memory is what lodbench foretells from sticks and triangles, as `--max-memory` does. "
            "Times are of one process, by the clock; frames this small cost mostly their ground.",
        ),
    ),
    "cover": Experiment(
        about="mean luminance by distance, pruned, with and without far cover, against everything",
        question="Does pruning keep the tone of the land from the nearest tree to the horizon?",
        run=_later("experiments.cover.measure", "run"),
        plots=_later("experiments.cover.plots", "plots"),
        point_table=_later("experiments.cover.plots", "table"),
        judge=_judge("experiments.cover.claims"),
        expected_seconds=(120.0, 900.0),
        caveats=(
            "Windows of 400 m, pictures of 160×90 pixels; `aerial` from 60 m up, because the land "
            "that it sees from 200 m cannot be held unpruned.",
            "One sun, 40° up, and headings near the presets' own: shade depends on both.",
            "A band is judged as a whole: what is too bright here and too dark there cancels out.",
        ),
    ),
    "pixels": Experiment(
        about="parts of an object against the pixels that it covers alone",
        question="Does an object ever consist of many more parts than the pixels it covers?",
        run=_later("experiments.pixels.measure", "run"),
        plots=_later("experiments.pixels.plots", "plots"),
        point_table=_later("experiments.pixels.plots", "table"),
        judge=_judge("experiments.pixels.claims"),
        accepts_metric=True,
        expected_seconds=(15.0, 60.0),
        caveats=(
            "Objects nearer than two of their bounds are left out: they cover far more pixels than "
            "they have parts.",
            "Flat ground and an eye 1.6 m up; each object is aimed at, as by a small picture.",
            "A pixel counts as covered when any of 16 places in it is.",
        ),
    ),
    "depth": Experiment(
        about="surfaces pierced by a ray to the limit, pruned and not",
        question="Is depth complexity bounded by pruning, and the same in every direction?",
        run=_later("experiments.depth.measure", "run"),
        plots=_later("experiments.depth.plots", "plots"),
        point_table=_later("experiments.depth.plots", "table"),
        judge=_judge("experiments.depth.claims"),
        expected_seconds=(16.0, 120.0),
        caveats=(
            "People on flat ground, level rays at the height of chests; every stick is a surface.",
            "The ground is not counted: a level ray never meets it.",
        ),
    ),
    "spectrum": Experiment(
        about="power spectra of pruned and unpruned pictures against the cut-off of m",
        question="Is pruning a low-pass filter?",
        run=_later("experiments.spectrum.measure", "run"),
        plots=_later("experiments.spectrum.plots", "plots"),
        point_table=_later("experiments.spectrum.plots", "table"),
        judge=_judge("experiments.spectrum.claims"),
        expected_seconds=(12.0, 25.0),
        caveats=(
            "Pictures of albedo alone, in clear air on flat ground: no light and no noise.",
            "Edges hold all frequencies: a filter takes them, and larger parts bring their own.",
        ),
    ),
    "cost": Experiment(
        about="seconds and bytes of a frame, stage by stage, and the metric's share",
        question="Is the metric cheap beside rendering, and is setting up done once and forgotten?",
        run=_later("experiments.cost.measure", "run"),
        timed=True,
        plots=_later("experiments.cost.plots", "plots"),
        point_table=_later("experiments.cost.plots", "table"),
        judge=_judge("experiments.cost.claims"),
        caveats=(
            "One preset, a small picture, wall-clock times of one machine; a larger picture with "
            "more samples makes the metric's share smaller.",
            "The metric alone is timed as arrays of distances; in the walk it is one with the "
            "search, whose whole time stands beside it.",
            "Memory is the most that a process has held, its libraries with it.",
        ),
        expected_seconds=(70.0, 280.0),
    ),
    "world": Experiment(
        about="one frame in worlds of 10³ to 10¹⁵ objects, and everything of small ones",
        question="Does a frame cost the same, however large the world is?",
        run=_later("experiments.world.measure", "run"),
        timed=True,
        plots=_later("experiments.world.plots", "plots"),
        point_table=_later("experiments.world.plots", "table"),
        judge=_judge("experiments.world.claims"),
        caveats=(
            "Worlds are endless fields seen through a window: none of their objects is stored, "
            "so that what grows with the world is what a frame examines, and nothing else.",
            "Seconds of one core, from prune to plain scene; rendering is the same for the same "
            "scene.",
            "Unpruned, only as far as the stated number of parts.",
        ),
        expected_seconds=(40.0, 120.0),
    ),
    "popping": Experiment(
        about="what comes and goes from frame to frame, how large it is, and what fading leaves",
        question="How many parts switch in a step, and does one see it?",
        run=_later("experiments.popping.measure", "run"),
        plots=_later("experiments.popping.plots", "plots"),
        point_table=_later("experiments.popping.plots", "table"),
        judge=_judge("experiments.popping.claims"),
        expected_seconds=(60.0, 170.0),
        caveats=(
            "Switches are counted all round on flat ground, at steps of two metres.",
            "Walks are rendered as albedo alone, in a window of 120 m: no light, no air, no noise.",
        ),
    ),
    "motion": Experiment(
        about="parts that an open shutter hides, and whether the blurred picture misses them",
        question="How much does velocity gain over size and distance?",
        run=_later("experiments.motion.measure", "run"),
        plots=_later("experiments.motion.plots", "plots"),
        point_table=_later("experiments.motion.plots", "table"),
        judge=_judge("experiments.motion.claims"),
        caveats=(
            "`meadow`, where nothing moves by itself, 640 pixels wide, 24 frames a second.",
            "Pictures are windows about the horizon, of one place, against the cut by size and "
            "distance alone; what that costs is the experiment `fidelity`.",
            "The share of a gain that size and distance have depends on how much there is to leave "
            "out: here everything in a square of 400 m, out of view as well.",
        ),
        expected_seconds=(180.0, 500.0),
    ),
    "updates": Experiment(
        about="how often parts are drawn again, how far off the others are, and what is saved",
        question="How many parts of what moves need drawing again in a frame?",
        run=_later("experiments.updates.measure", "run"),
        plots=_later("experiments.updates.plots", "plots"),
        point_table=_later("experiments.updates.plots", "table"),
        judge=_judge("experiments.updates.claims"),
        caveats=(
            "A crowd among trees in wind of 6 m/s, 320 pixels wide, 24 frames a second: shares "
            "grow with the picture.",
            "Every frame is scheduled by itself, so that frames may come in any order: nothing of "
            "a frame is kept in memory for the next, and time can only be lost.",
        ),
        expected_seconds=(90.0, 240.0),
    ),
}
