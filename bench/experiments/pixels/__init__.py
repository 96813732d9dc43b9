"""What does the experiment `pixels` ask, which functions answer it, and what is shown?"""

from bench.old_experiment import Experiment, functions_of

EXPERIMENT = Experiment(
    name="pixels",
    order=90,
    version=1,
    about=("parts of an object against the pixels that it covers alone"),
    question=("Does an object ever consist of many more parts than the pixels it covers?"),
    full={"objects": 1000},
    quick={"objects": 150},
    expected_seconds={"full": 60.0, "quick": 15.0},
    **functions_of(__name__, scene_hash="bench.part_sizes"),
    accepts_metric=True,
    caveats=(
        "Objects nearer than two of their bounds are left out: they cover far more pixels than "
        "they have parts.",
        "Flat ground and an eye 1.6 m up; each object is aimed at, as by a small picture.",
        "A pixel counts as covered when any of 16 places in it is.",
    ),
)
