"""What does the experiment `scaling` ask, which functions answer it, and what is shown?"""

from bench.old_experiment import Experiment, functions_of

EXPERIMENT = Experiment(
    name="scaling",
    order=10,
    version=3,
    about=("objects and parts against K(P+R)²/m², prefactor and all; and where that breaks"),
    question=(
        "Does the number of things in a frame depend on what the viewer can resolve, "
        "and not on the size of the world?"
    ),
    full={"target": 0.005, "least": 4, "most": 20_000},
    quick={"target": 0.01, "least": 2, "most": 4_000},
    expected_seconds={"full": 400.0, "quick": 110.0},
    **functions_of(__name__, "notes", scene_hash="count_field"),
    accepts_metric=True,
    caveats=(
        "An eye that looks all round; a field of view has predictions of its own (`lodbench "
        "count`).",
        "Hills of one shape, patches of one kind, haze of one visibility: they show where the "
        "bare law breaks, and that the law with its terms does not.",
        "Counts, not seconds: what a frame costs is another experiment.",
    ),
)
