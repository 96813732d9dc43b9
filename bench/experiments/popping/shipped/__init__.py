"""What does `popping_shipped` ask, which functions answer it, and what is shown?"""

from bench.old_experiment import Experiment, functions_of

EXPERIMENT = Experiment(
    name="popping_shipped",
    order=141,
    version=1,
    apart=True,
    about="what motion does not explain of walks through presets as shipped, in shaded pictures",
    question="Does one see parts come and go, or the ground swim, in a preset as it is shipped?",
    full={
        "presets": ["forest", "mountain", "meadow"],
        "pairs": 48,
        "unseen": True,
        "size": "320x180",
        "spp": 16,
    },
    quick={"presets": ["meadow"], "pairs": 2, "unseen": False, "size": "64x36", "spp": 4},
    expected_seconds={"full": 900.0, "quick": 60.0},
    **functions_of(__name__),
    rendered=True,
    caveats=(
        "Pictures have no noise, for both of a pair have the same samples; and no shadow, air or "
        "bounced light: a shadow that jumps is not seen.",
        "One walk through each preset, 1.4 m a second for two seconds: its pairs of frames are "
        "neighbours, so intervals over them are somewhat too narrow.",
    ),
)
