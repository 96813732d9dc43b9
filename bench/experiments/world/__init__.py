"""What does the experiment `world` ask, which functions answer it, and what is shown?"""

from bench.old_experiment import Experiment, functions_of

EXPERIMENT = Experiment(
    name="world",
    order=130,
    version=1,
    about=("one frame in worlds of 10³ to 10¹⁵ objects, and everything of small ones"),
    question=("Does a frame cost the same, however large the world is?"),
    full={"repeats": 31},
    quick={"repeats": 8},
    expected_seconds={"full": 120.0, "quick": 40.0},
    **functions_of(__name__, "notes"),
    timed=True,
    probe="crowd",
    caveats=(
        "Worlds are endless fields seen through a window: none of their objects is stored, "
        "so that what grows with the world is what a frame examines, and nothing else.",
        "Seconds of one core, from prune to plain scene; rendering is the same for the same scene.",
        "Unpruned, only as far as the stated number of parts.",
    ),
)
