"""What does the experiment `depth` ask, which functions answer it, and what is shown?"""

from bench.old_experiment import Experiment, functions_of

EXPERIMENT = Experiment(
    name="depth",
    order=100,
    version=1,
    about=("surfaces pierced by a ray to the limit, pruned and not"),
    question=("Is depth complexity bounded by pruning, and the same in every direction?"),
    full={"fields": 400},
    quick={"fields": 60},
    expected_seconds={"full": 35.0, "quick": 16.0},
    **functions_of(__name__, "notes", scene_hash="bench.fields.part_sizes"),
    caveats=(
        "People on flat ground, level rays at the height of chests; every stick is a surface.",
        "The ground is not counted: a level ray never meets it.",
    ),
)
