"""What does the experiment `rivals` ask, which functions answer it, and what is shown?"""

from bench.runner.experiment import Experiment, functions_of

EXPERIMENT = Experiment(
    name="rivals",
    order=130,
    version=1,
    about="the same frames by other methods of simplification, at equal error",
    question="What do a frame's time and memory come to by other methods, at the same error?",
    full={
        "kinds": ["crowd", "meadow", "swaying", "forest"],
        "objects": [1e4, 1e5],
        "fields": 4,
        "size": "640x360",
        "spp": 16,
        "pairs": 2,
        "repeats": 4,
    },
    quick={
        "kinds": ["crowd", "meadow"],
        "objects": [1e3],
        "fields": 2,
        "size": "160x90",
        "spp": 16,
        "pairs": 2,
        "repeats": 2,
    },
    expected_seconds={"full": 18_000.0, "quick": 420.0},
    **functions_of(__name__, "summary", scene_hash="windows", cases="windows"),
    rendered=True,
    timed=True,
    all_cores=True,
    apart=True,
    caveats=(
        "Level ground, own models, one sun, one renderer. A renderer that instances would hold a "
        "still world of few prototypes in far less memory than `full` does here.",
        "`full` is built once where nothing moves: its seconds there are those of a later frame.",
        "A ray-tracing level of detail (Yoon et al. 2006) stops at a node of the acceleration "
        "structure; Mitsuba's, from Embree and OptiX, cannot be stopped, and one of our own would "
        "be compared with those by its code and not by its idea. It is not measured.",
        "An arm that no setting brings to equal error is not compared; the table says which.",
    ),
)
