"""What does the experiment `figure` ask, which functions answer it, and what is shown?"""

from bench.old_experiment import Experiment, functions_of

EXPERIMENT = Experiment(
    name="figure",
    order=20,
    version=1,
    about=("parts of one object against distance and level, and what posing it costs"),
    question=("Do the parts of a figure drop off with the square root of its distance?"),
    full={"poses": 200, "distances": 60, "repeats": 101, "posed": 4000},
    quick={"poses": 40, "distances": 30, "repeats": 21, "posed": 1000},
    expected_seconds={"full": 10.0, "quick": 5.0},
    **functions_of(__name__, "notes", cases="cases", scene_hash="part_counts"),
    accepts_metric=True,
    caveats=(
        "One person and one of each kind, as tables made them: intervals are over poses, "
        "directions and places in the grid of distances, not over other people or animals.",
        "An exponent is that of the straight line nearest to a curve which is not straight: "
        "its nearer and farther halves stand in the table of points.",
        "Times are those of one machine, its compiler and these two kernels; they say which "
        "is cheaper here.",
    ),
)
