"""What does the experiment `haze` ask, which functions answer it, and what is shown?"""

from bench.old_experiment import Experiment, functions_of

EXPERIMENT = Experiment(
    name="haze",
    order=30,
    version=1,
    about=("what haze takes of each size of part, from V = 0.5 to 50 km, measured and predicted"),
    question=("Which parts does haze hide, and does the law know how many?"),
    full={"fields": 80},
    quick={"fields": 12},
    expected_seconds={"full": 80.0, "quick": 60.0},
    **functions_of(__name__, scene_hash="bench.part_sizes"),
    caveats=(
        "Flat ground and an eye 1.6 m up that looks all round; nothing hides anything.",
        "What is gone is what Barten's standard observer could not see on a display of 100 "
        "cd/m²; a tone curve that steepens contrast shows more.",
        "Shares depend on m·V alone, as long as contrast classes are the same: a finer picture "
        "shows more far parts for haze to take.",
    ),
)
