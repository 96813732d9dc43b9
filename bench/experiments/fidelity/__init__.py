"""What does the experiment `fidelity` ask, which functions answer it, and what is shown?"""

from bench.old_experiment import Experiment, functions_of

EXPERIMENT = Experiment(
    name="fidelity",
    order=70,
    version=5,
    about="image error, tone and coverage by distance over fields; metrics at equal error",
    question="What does pruning do to the picture, and which metric does least for its parts?",
    full={
        "fields": 12,
        "size": "320x180",
        "samples": [32, 128],
        "light_passes": 16,
        "sweep_fields": 4,
        "sweep_size": "160x90",
        "sweep_samples": [32, 128, 32, 128],
        "details": [0.5, 1.0, 2.0, 4.0],
        "grass_details": [0.0625, 0.25, 1.0, 4.0],
        "unseen": True,
        "picture_spp": 64,
    },
    quick={
        "fields": 4,
        "size": "64x36",
        "samples": [32, 128],
        "light_passes": 16,
        "sweep_fields": 2,
        "sweep_size": "64x36",
        "sweep_samples": [32, 128, 32, 128],
        "details": [0.5, 2.0],
        "grass_details": [0.0625, 0.5, 4.0],
        "unseen": False,
        "picture_spp": 9,
    },
    expected_seconds={"full": 2600.0, "quick": 230.0},
    **functions_of(__name__, "notes", "summary", scene_hash="scene"),
    rendered=True,
    accepts_metric=True,
    caveats=(
        "Fields of one preset, with its own trees and people, under three suns and no cloud.",
        "The reference is not the unpruned world, which no memory holds: species are pruned at an "
        "eighth of a pixel in it and the ground at a quarter. What lies beyond 10 km is not there.",
        "Grass is compared in a window of 80 m and at a FLIP of 0.05, both chosen on fields for "
        "building. The other views have no grass.",
        "Pictures have 320×180 pixels, in sweeps 160×90. FLIP is of one exposure and 67 pixels per "
        "degree; more of either shows more. Error without noise is fitted through two counts of "
        "samples; the reference against itself says how far that can be trusted.",
        "Light by distance is seen through the air of the view, which is the same in both "
        "pictures; far away much of it is airlight. `cover` takes it away.",
    ),
)
