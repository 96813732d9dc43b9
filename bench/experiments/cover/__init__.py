"""What does the experiment `cover` ask, which functions answer it, and what is shown?"""

from bench.runner.experiment import Experiment, functions_of

EXPERIMENT = Experiment(
    name="cover",
    order=80,
    version=2,
    about=("mean luminance by distance, pruned, with and without far cover, against everything"),
    question=("Does pruning keep the tone of the land from the nearest tree to the horizon?"),
    full={"fields": {"aerial": 16, "forest": 40}},
    quick={"fields": {"aerial": 2, "forest": 2}},
    expected_seconds={"full": 900.0, "quick": 120.0},
    **functions_of(__name__, "notes"),
    rendered=True,
    caveats=(
        "Windows of 400 m, pictures of 160×90 pixels; `aerial` from 60 m up, because the land "
        "that it sees from 200 m cannot be held unpruned.",
        "One sun, 40° up, and headings near the presets' own: shade depends on both.",
        "A band is judged as a whole: what is too bright here and too dark there cancels out.",
    ),
)
