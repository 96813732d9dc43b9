"""What does the experiment `depth` ask, which functions answer it, and what is shown?"""

from bench.runner.experiment import Experiment, Lazy

EXPERIMENT = Experiment(
    name="depth",
    order=100,
    version=1,
    about=("surfaces pierced by a ray to the limit, pruned and not"),
    question=("Is depth complexity bounded by pruning, and the same in every direction?"),
    full={"fields": 400},
    quick={"fields": 60},
    expected_seconds={"full": 120.0, "quick": 16.0},
    cases=Lazy(f"{__name__}.measure", "cases"),
    measure=Lazy(f"{__name__}.measure", "measure"),
    judge=Lazy(f"{__name__}.claims", "judge"),
    plots=Lazy(f"{__name__}.plots", "plots"),
    point_table=Lazy(f"{__name__}.plots", "point_table"),
    scene_hash=Lazy(f"{__name__}.measure", "scene_hash"),
    notes=Lazy(f"{__name__}.measure", "notes"),
    caveats=(
        "People on flat ground, level rays at the height of chests; every stick is a surface.",
        "The ground is not counted: a level ray never meets it.",
    ),
)
