"""The experiments, by name. What one needs is imported when it is used: listing them is fast."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol, runtime_checkable

if TYPE_CHECKING:
    import bench.figures
    import bench.records
    from bench.spread import Each

Progress = Callable[[int, int, str], None]
"""Called with points done, points in all, and what comes next."""

Table = tuple[tuple[str, ...], list[tuple[str, ...]]]
"""Heads and rows."""


def silent(done: int, total: int, what: str) -> None:
    """No progress shown."""


@runtime_checkable
class Run(Protocol):
    """Measures and judges; ``quick`` has the same points and fewer fields."""

    def __call__(
        self, quick: bool = False, progress: Progress = silent, seed: int = 0
    ) -> "bench.records.Record":
        """The finished record."""


@runtime_checkable
class RunSpread(Protocol):
    """As Run, with cases measured wherever ``each`` has them measured."""

    def __call__(
        self, quick: bool, progress: Progress, seed: int, each: "Each"
    ) -> "bench.records.Record":
        """The finished record."""


@dataclass(frozen=True)
class Experiment:
    """One question, the way to answer it, what its record shows, and what that does not say.

    run_spread  over many machines; None where it measures time, or is one case
    """

    about: str
    question: str
    run: Run
    figures: Callable[["bench.records.Record"], tuple["bench.figures.Figure", ...]]
    table: Callable[["bench.records.Record"], Table]
    limits: tuple[str, ...]
    run_spread: RunSpread | None = None


def _run_scaling(
    quick: bool = False, progress: Progress = silent, seed: int = 0
) -> "bench.records.Record":
    from bench import scaling

    return scaling.run(quick, progress, seed)


def _spread_scaling(
    quick: bool, progress: Progress, seed: int, each: "Each"
) -> "bench.records.Record":
    from bench import scaling

    return scaling.run(quick, progress, seed, each)


def _spread_figure(
    quick: bool, progress: Progress, seed: int, each: "Each"
) -> "bench.records.Record":
    """The counts; posing is timed here."""
    from bench import figure_experiment

    return figure_experiment.run(quick, progress, seed, each)


def _scaling_figures(record: "bench.records.Record") -> tuple["bench.figures.Figure", ...]:
    from bench import scaling_figures

    return scaling_figures.figures(record)


def _scaling_table(record: "bench.records.Record") -> Table:
    from bench import scaling_figures

    return scaling_figures.table(record)


def _run_figure(
    quick: bool = False, progress: Progress = silent, seed: int = 0
) -> "bench.records.Record":
    from bench import figure_experiment

    return figure_experiment.run(quick, progress, seed)


def _figure_figures(record: "bench.records.Record") -> tuple["bench.figures.Figure", ...]:
    from bench import figure_plots

    return figure_plots.figures(record)


def _figure_table(record: "bench.records.Record") -> Table:
    from bench import figure_plots

    return figure_plots.table(record)


def _run_haze(
    quick: bool = False, progress: Progress = silent, seed: int = 0
) -> "bench.records.Record":
    from bench import haze_experiment

    return haze_experiment.run(quick, progress, seed)


def _haze_figures(record: "bench.records.Record") -> tuple["bench.figures.Figure", ...]:
    from bench import haze_plots

    return haze_plots.figures(record)


def _haze_table(record: "bench.records.Record") -> Table:
    from bench import haze_plots

    return haze_plots.table(record)


def _run_eye(
    quick: bool = False, progress: Progress = silent, seed: int = 0
) -> "bench.records.Record":
    from bench import eye_experiment

    return eye_experiment.run(quick, progress, seed)


def _eye_figures(record: "bench.records.Record") -> tuple["bench.figures.Figure", ...]:
    from bench import eye_plots

    return eye_plots.figures(record)


def _eye_table(record: "bench.records.Record") -> Table:
    from bench import eye_plots

    return eye_plots.table(record)


def _run_colonnade(
    quick: bool = False, progress: Progress = silent, seed: int = 0
) -> "bench.records.Record":
    from bench import colonnade_experiment

    return colonnade_experiment.run(quick, progress, seed)


def _colonnade_figures(record: "bench.records.Record") -> tuple["bench.figures.Figure", ...]:
    from bench import colonnade_plots

    return colonnade_plots.figures(record)


def _colonnade_table(record: "bench.records.Record") -> Table:
    from bench import colonnade_plots

    return colonnade_plots.table(record)


def _run_air(
    quick: bool = False, progress: Progress = silent, seed: int = 0
) -> "bench.records.Record":
    from bench import air_experiment

    return air_experiment.run(quick, progress, seed)


def _air_figures(record: "bench.records.Record") -> tuple["bench.figures.Figure", ...]:
    from bench import air_plots

    return air_plots.figures(record)


def _air_table(record: "bench.records.Record") -> Table:
    from bench import air_plots

    return air_plots.table(record)


EXPERIMENTS: dict[str, Experiment] = {
    "scaling": Experiment(
        about="objects and parts against K(P+R)²/m² and the size of the world, prefactor and all",
        question="Does the number of things in a frame depend on what the viewer can resolve, "
        "and not on the size of the world?",
        run=_run_scaling,
        run_spread=_spread_scaling,
        figures=_scaling_figures,
        table=_scaling_table,
        limits=(
            "Flat ground, clear air and an eye without blur, looking all round; hills, haze and "
            "fields of view have predictions of their own (`lodbench count`).",
            "Objects are spread at random and evenly; real meadows have clusters.",
            "Counts, not seconds: what a frame costs is another experiment.",
        ),
    ),
    "figure": Experiment(
        about="parts of one object against distance and level, and what posing it costs",
        question="Do the parts of a figure drop off with the square root of its distance?",
        run=_run_figure,
        run_spread=_spread_figure,
        figures=_figure_figures,
        table=_figure_table,
        limits=(
            "One person and one of each kind, as tables made them: intervals are over poses, "
            "directions and places in the grid of distances, not over other people or animals.",
            "An exponent is that of the straight line nearest to a curve which is not straight: "
            "its nearer and farther halves stand in the table of points.",
            "Times are those of one machine, its compiler and these two kernels; they say which "
            "is cheaper here.",
        ),
    ),
    "haze": Experiment(
        about="what haze takes of each size of part, from V = 0.5 to 50 km, measured and predicted",
        question="Which parts does haze hide, and does the law know how many?",
        run=_run_haze,
        figures=_haze_figures,
        table=_haze_table,
        limits=(
            "Flat ground and an eye 1.6 m up that looks all round; nothing hides anything.",
            "What is gone is what Barten's standard observer could not see on a display of 100 "
            "cd/m²; a tone curve that steepens contrast shows more.",
            "Shares depend on m·V alone, as long as contrast classes are the same: a finer picture "
            "shows more far parts for haze to take.",
        ),
    ),
    "eye": Experiment(
        about="what display and eye leave out, from 20 to 120 pixels per degree",
        question="How much detail is lost on the eye, by blur and by contrast?",
        run=_run_eye,
        figures=_eye_figures,
        table=_eye_table,
        limits=(
            "Clear air, flat ground, a picture that stays 640 pixels wide.",
            "One standard observer, 20 to 30 years old, on a display of 100 cd/m² and 53°.",
            "A part is a half-period of a grating of its own size; what eyes make of edges, colour "
            "and movement is not in it.",
        ),
    ),
    "colonnade": Experiment(
        about="Leonardo's columns: solid angle against image size, true distance against depth",
        question="Does true distance take detail from where it is seen least?",
        run=_run_colonnade,
        figures=_colonnade_figures,
        table=_colonnade_table,
        limits=(
            "One row of one kind of column, looked at from one place with a wide view.",
            "Errors at the eye are those of an eye at the centre of projection; who stands "
            "elsewhere sees the error in the image.",
            "Depth is the coarser the finer it is asked to be: its cut with about as many parts is "
            "the nearest that there is.",
        ),
    ),
    "air": Experiment(
        about="haze as rendered: targets, the medium that scatters light, and spectral light",
        question="Is the haze in the pictures what theory, a scattering medium and light of "
        "sixteen bands make of it?",
        run=_run_air,
        figures=_air_figures,
        table=_air_table,
        limits=(
            "The closed forms leave out that air dims the light on its way to the ground, that it "
            "lies in the shade of what stands in it, and that its glow varies with height; the "
            "airlight of the horizon's sky also leaves out which way the sun stands to the air.",
            "The medium is a layer 10 m higher than the scene, under a sky that holds a whole "
            "atmosphere already; its phase function is one of clean continental air.",
            "RGB and spectral pictures also differ in the coefficients of the sky's model: the "
            "row of the sky shows by how much.",
        ),
    ),
}
