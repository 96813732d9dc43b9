"""What does the experiment `cost` ask, which functions answer it, and what is shown?"""

from bench.runner.experiment import Experiment, functions_of

EXPERIMENT = Experiment(
    name="cost",
    order=120,
    version=1,
    about=("seconds and bytes of a frame, stage by stage, and the metric's share"),
    question=("Is the metric cheap beside rendering, and is setting up done once and forgotten?"),
    full={"processes": 8},
    quick={"processes": 2},
    expected_seconds={"full": 280.0, "quick": 70.0},
    **functions_of(__name__, "notes"),
    rendered=True,
    timed=True,
    all_cores=True,
    caveats=(
        "One preset, a small picture, wall-clock times of one machine; a larger picture with "
        "more samples makes the metric's share smaller.",
        "The metric alone is timed as arrays of distances; in the walk it is one with the "
        "search, whose whole time stands beside it.",
        "Memory is the most that a process has held, its libraries with it.",
    ),
)
