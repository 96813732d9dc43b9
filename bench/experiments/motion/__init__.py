"""What does the experiment `motion` ask, which functions answer it, and what is shown?"""

from bench.old_experiment import Experiment, functions_of

EXPERIMENT = Experiment(
    name="motion",
    order=150,
    version=2,
    about=("parts that an open shutter hides, and whether the blurred picture misses them"),
    question=("How much does velocity gain over size and distance?"),
    full={"fields": 12, "samples_per_pixel": 576, "pictured": 5},
    quick={"fields": 4, "samples_per_pixel": 32, "pictured": 1},
    expected_seconds={"full": 270.0, "quick": 180.0},
    **functions_of(__name__),
    rendered=True,
    caveats=(
        "`meadow`, where nothing moves by itself, 640 pixels wide, 24 frames a second.",
        "Pictures are windows about the horizon, of one place, against the cut by size and "
        "distance alone; what that costs is the experiment `fidelity`.",
        "The share of a gain that size and distance have depends on how much there is to leave "
        "out: here everything in a square of 400 m, out of view as well.",
    ),
)
