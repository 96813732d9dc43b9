"""What does the experiment `rivals` ask, which functions answer it, and what is shown?"""

from typing import Any

from bench.old_experiment import Experiment, functions_of

_KINDS = "crowd", "meadow", "swaying", "forest", "swaying forest"
_RIVALS = "blake", "full", "distance", "in_view", "discrete", "stochastic"
_FEW = "blake", "full", "in_view", "discrete"


def _worlds(
    kinds: tuple[str, ...], sizes: tuple[float, ...], fields: int, few: tuple[str, ...] = ()
) -> list[list[Any]]:
    """List kinds and sizes of worlds, the number of fields, and the arms; none = all."""
    return [[kind, objects, fields, list(few)] for objects in sizes for kind in kinds]


EXPERIMENT = Experiment(
    name="rivals",
    order=130,
    version=2,
    about="the same frames by other methods of simplification, at equal error",
    question="What do a frame's time and memory come to by other methods, at the same error?",
    full={
        "worlds": [
            *_worlds(("crowd",), (1e5,), 4, _RIVALS),
            *_worlds(("forest", "swaying forest"), (1e4,), 4, _RIVALS),
            *_worlds(_KINDS[:3], (1e4,), 2),
            *_worlds(_KINDS[1:], (1e5,), 2, _RIVALS),
            *_worlds(("from above",), (1e5,), 2, _RIVALS),
            *_worlds(_KINDS, (1e3, 1e6), 2, _FEW),
        ],
        "walk": ["crowd", 1e4, "320x180", 48],
        "cycles": [["crowd", 1e4], ["meadow", 1e4]],
        "size": "320x180",
        "spp": 16,
        "pairs": 2,
        "repeats": 4,
        "weighed": 2,
    },
    quick={
        "worlds": [
            *_worlds(("crowd", "meadow"), (1e3,), 2),
            *_worlds(("swaying",), (300.0,), 2),
            *_worlds(("forest", "swaying forest"), (300.0,), 2, _RIVALS),
        ],
        "walk": ["crowd", 300.0, "160x90", 8],
        "cycles": [["crowd", 1e3], ["meadow", 1e3]],
        "size": "160x90",
        "spp": 16,
        "pairs": 2,
        "repeats": 2,
        "weighed": 1,
    },
    expected_seconds={"full": 18_000.0, "quick": 600.0},
    **functions_of(__name__, "summary", "tables"),
    rendered=True,
    timed=True,
    all_cores=True,
    apart=True,
    whole_cases=True,
    caveats=(
        "Level ground without grass, as trees and people are compared; own models, one sun, one "
        "renderer but for Cycles. A renderer that instances would hold a still world of few "
        "prototypes in far less memory than `full` does here.",
        "`full` is built once where nothing moves: its seconds there are those of a later frame.",
        "A ray-tracing level of detail (Yoon et al. 2006) stops at a node of the acceleration "
        "structure; Mitsuba's, from Embree and OptiX, cannot be stopped, and one of our own would "
        "be compared with those by its code and not by its idea. It is not measured.",
        "An arm that no setting brings to equal error is not compared; the table says which.",
    ),
)
