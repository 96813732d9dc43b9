"""What does `fidelity_shipped` ask, which functions answer it, and what is shown?"""

from bench.old_experiment import Experiment, functions_of

EXPERIMENT = Experiment(
    name="fidelity_shipped",
    order=71,
    version=1,
    apart=True,
    about="image error of every preset as shipped, against pictures far finer, in places unseen",
    question="Pruned as it is shipped, is a preset's picture one that nobody can tell from whole?",
    full={
        "presets": {
            **dict.fromkeys(("meadow", "forest", "aerial", "mountain", "badlands"), 6),
            **dict.fromkeys(("crowd", "zoo", "campfire", "playground"), 6),
            "fly_in": 3,
        },
        "apart": ["mountain", "badlands", "meadow", "aerial"],
        "size": "320x180",
        "unseen": True,
        "samples": [16, 64, 256],
        "light_passes": 32,
        "reference_bytes": 3_000_000_000,
    },
    quick={
        "presets": {"mountain": 2, "meadow": 2, "fly_in": 2},
        "apart": ["mountain"],
        "size": "64x36",
        "unseen": False,
        "samples": [4, 16, 64],
        "light_passes": 16,
        "reference_bytes": 600_000_000,
    },
    expected_seconds={"full": 9500.0, "quick": 120.0},
    **functions_of(__name__, "summary"),
    rendered=True,
    caveats=(
        "The reference is the same preset, far finer: what the preset itself leaves out at any "
        "detail, as what its air hides and relief below its finest mesh, is in neither picture.",
        "Pictures have 320×180 pixels (a quick run: 64×36). FLIP is of one exposure and 67 pixels "
        "per degree; more of either shows more. No person has looked.",
        "The noise of stratified samples does not fall exactly as 1/√N, so the fit errs: by what "
        "is found of a reference against itself, and by 0.001 to 0.002 on the low side in two "
        "presets that were traced with up to 1024 samples. FLIP with the most samples is too high.",
        "The luminance of the land is seen through the preset's own air, which is in both "
        "pictures; far away most of it is airlight.",
    ),
)
