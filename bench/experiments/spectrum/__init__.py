"""What does the experiment `spectrum` ask, which functions answer it, and what is shown?"""

from bench.runner.experiment import Experiment, Lazy

EXPERIMENT = Experiment(
    name="spectrum",
    order=110,
    version=1,
    about=("power spectra of pruned and unpruned pictures against the cut-off of m"),
    question=("Is pruning a low-pass filter?"),
    full={"directions": 8},
    quick={"directions": 3},
    expected_seconds={"full": 25.0, "quick": 12.0},
    cases=Lazy(f"{__name__}.measure", "cases"),
    measure=Lazy(f"{__name__}.measure", "measure"),
    judge=Lazy(f"{__name__}.claims", "judge"),
    plots=Lazy(f"{__name__}.plots", "plots"),
    point_table=Lazy(f"{__name__}.plots", "point_table"),
    scene_hash=Lazy(f"{__name__}.measure", "scene_hash"),
    rendered=True,
    caveats=(
        "Pictures of albedo alone, in clear air on flat ground: no light and no noise.",
        "Edges hold all frequencies: a filter takes them, and larger parts bring their own.",
    ),
)
