"""What does the experiment `spectrum` ask, which functions answer it, and what is shown?"""

from bench.old_experiment import Experiment, functions_of

EXPERIMENT = Experiment(
    name="spectrum",
    order=110,
    version=1,
    about=("power spectra of pruned and unpruned pictures against the cut-off of m"),
    question=("Is pruning a low-pass filter?"),
    full={"directions": 8},
    quick={"directions": 3},
    expected_seconds={"full": 25.0, "quick": 12.0},
    **functions_of(__name__),
    rendered=True,
    caveats=(
        "Pictures of albedo alone, in clear air on flat ground: no light and no noise.",
        "Edges hold all frequencies: a filter takes them, and larger parts bring their own.",
    ),
)
