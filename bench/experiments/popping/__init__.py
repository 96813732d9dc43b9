"""What does the experiment `popping` ask, which functions answer it, and what is shown?"""

from bench.old_experiment import Experiment, functions_of

EXPERIMENT = Experiment(
    name="popping",
    order=140,
    version=3,
    about=("what comes and goes from frame to frame, how large it is, and what fading leaves"),
    question=("How many parts switch in a step, and does one see it?"),
    full={"fields": 100, "walks": 12, "unseen": True},
    quick={"fields": 24, "walks": 3, "unseen": False},
    expected_seconds={"full": 260.0, "quick": 70.0},
    **functions_of(__name__),
    rendered=True,
    caveats=(
        "Switches are counted all round on flat ground, at steps of two metres.",
        "Walks are rendered as albedo alone, in a window of 120 m: no light, no air, no noise.",
    ),
)
