"""What does the experiment `updates` ask, which functions answer it, and what is shown?"""

from bench.old_experiment import Experiment, functions_of

EXPERIMENT = Experiment(
    name="updates",
    order=160,
    version=2,
    about=("how often parts are drawn again, how far off the others are, and what is saved"),
    question=("How many parts of what moves need drawing again in a frame?"),
    full={"fields": 8, "rounds": 6},
    quick={"fields": 3, "rounds": 3},
    expected_seconds={"full": 140.0, "quick": 90.0},
    **functions_of(__name__),
    rendered=True,
    caveats=(
        "A crowd among trees in wind of 6 m/s, 320 pixels wide, 24 frames a second: shares "
        "grow with the picture.",
        "Every frame is scheduled by itself, so that frames may come in any order: nothing of "
        "a frame is kept in memory for the next, and time can only be lost.",
    ),
)
