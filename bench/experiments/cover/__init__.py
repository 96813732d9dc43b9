"""What does the experiment `cover` ask, which functions answer it, and what is shown?"""

from bench.old_experiment import Experiment, functions_of

EXPERIMENT = Experiment(
    name="cover",
    order=80,
    version=4,
    about=("tone and coverage by distance to 5 km, with and without far cover, against everything"),
    question=("Does pruning keep the tone of the land from the nearest tree to the horizon?"),
    full={
        "fields": {"aerial": 16, "forest": 32, "far_1_km": 32, "far_2.2_km": 32, "far_5_km": 32},
        "unseen": True,
    },
    quick={
        "fields": {"aerial": 3, "forest": 3, "far_1_km": 4, "far_2.2_km": 4, "far_5_km": 4},
        "unseen": False,
    },
    expected_seconds={"full": 1350.0, "quick": 200.0},
    **functions_of(__name__, "notes"),
    rendered=True,
    probe="aerial",
    caveats=(
        "Windows of 280 and 400 m, pictures of 160×90 pixels; `aerial` from 60 m up, because the "
        "land that it sees from 200 m cannot be held unpruned. Far looks show a window of "
        "`aerial` alone, 1, 2.2 and 5 km away and at least 8° below the eye, on nearly level land.",
        "One sun, 40° up, and headings near the presets' own: shade depends on both.",
        "A band is judged as a whole: what is too bright here and too dark there cancels out.",
    ),
)
