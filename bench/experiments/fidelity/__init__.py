"""What does the experiment `fidelity` ask, which functions answer it, and what is shown?"""

from bench.runner.experiment import Experiment, functions_of

EXPERIMENT = Experiment(
    name="fidelity",
    order=70,
    version=3,
    about=("image error against parts, memory and time, every metric, τ from ⅛ to 8 pixels"),
    question=("What does pruning do to the picture, and which metric does least for its parts?"),
    full={
        "details": (0.125, 0.25, 0.5, 1.0, 2.0, 4.0, 8.0),
        "ground_details": (0.25, 1.0, 4.0),
        "timed_details": (0.125, 0.5, 1.0, 2.0, 8.0),
        "samples_per_pixel": {"eye level": 225, "aerial": 441, "hazy": 64},
        "picture_spp": 64,
    },
    quick={
        "details": (0.25, 1.0, 4.0),
        "ground_details": (1.0,),
        "timed_details": (1.0,),
        "samples_per_pixel": {"eye level": 25, "aerial": 25, "hazy": 25},
        "picture_spp": 9,
    },
    expected_seconds={"full": 900.0, "quick": 120.0},
    **functions_of(__name__, "notes", "summary"),
    rendered=True,
    accepts_metric=True,
    caveats=(
        "One meadow in a window 240 m wide, in three views of 64×36 pixels: pixels are large, "
        "and so are the limits that they set; what lies beyond 170 m is not there at all.",
        "FLIP is of one exposure and 67 pixels per degree; more of either shows more.",
        "Memory is what lodbench foretells from sticks and triangles, as `--max-memory` does. "
        "Times are of one process, by the clock; frames this small cost mostly their ground.",
    ),
)
