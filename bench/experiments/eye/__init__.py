"""What does the experiment `eye` ask, which functions answer it, and what is shown?"""

from bench.old_experiment import Experiment, functions_of

EXPERIMENT = Experiment(
    name="eye",
    order=40,
    version=1,
    about=("what display and eye leave out, from 20 to 120 pixels per degree"),
    question=("How much detail is lost on the eye, by blur and by contrast?"),
    full={"fields": 60},
    quick={"fields": 10},
    expected_seconds={"full": 40.0, "quick": 30.0},
    **functions_of(__name__, scene_hash="bench.part_sizes"),
    caveats=(
        "Clear air, flat ground, a picture that stays 640 pixels wide.",
        "One standard observer, 20 to 30 years old, on a display of 100 cd/m² and 53°.",
        "A part is a half-period of a grating of its own size; what eyes make of edges, colour "
        "and movement is not in it.",
    ),
)
