"""What does the experiment `colonnade` ask, which functions answer it, and what is shown?"""

from bench.old_experiment import Experiment, functions_of

EXPERIMENT = Experiment(
    name="colonnade",
    order=50,
    version=1,
    about=("Leonardo's columns: solid angle against image size, true distance against depth"),
    question=("Does true distance take detail from where it is seen least?"),
    full={"seeds": 8},
    quick={"seeds": 3},
    expected_seconds={"full": 120.0, "quick": 60.0},
    **functions_of(__name__, "notes"),
    rendered=True,
    caveats=(
        "One row of one kind of column, looked at from one place with a wide view.",
        "Errors at the eye are those of an eye at the centre of projection; who stands "
        "elsewhere sees the error in the image.",
        "Depth is the coarser the finer it is asked to be: its cut with about as many parts is "
        "the nearest that there is.",
    ),
)
