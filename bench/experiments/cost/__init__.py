"""What does the experiment `cost` ask, which functions answer it, and what is shown?"""

from bench.old_experiment import Experiment, functions_of

EXPERIMENT = Experiment(
    name="cost",
    order=120,
    version=2,
    about="seconds and bytes of a frame, stage by stage; of larger worlds pruned and whole",
    question="Is the metric cheap beside rendering, and what does pruning save, stage by stage?",
    full={
        "processes": 8,
        "worlds": {"meadow": [1e3, 1e4, 3e4], "crowd": [1e3, 1e4, 1e5]},
        "fields": 3,
        "unseen": True,
        "size": "320x180",
        "spp": 64,
        "frames": 4,
        "samples": [32, 128],
    },
    quick={
        "processes": 2,
        "worlds": {"meadow": [300.0], "crowd": [1e3]},
        "fields": 2,
        "unseen": False,
        "size": "64x36",
        "spp": 16,
        "frames": 2,
        "samples": [16, 64],
    },
    expected_seconds={"full": 1400.0, "quick": 60.0},
    **functions_of(__name__, "notes", "summary"),
    rendered=True,
    timed=True,
    all_cores=True,
    caveats=(
        "Small pictures, wall-clock times of one machine; a larger picture with more samples makes "
        "the shares of the metric and of all set-up smaller, for tracing takes as long either way.",
        "The metric alone is timed as arrays of distances; in the walk it is one with the "
        "search, whose whole time stands beside it.",
        "Memory is the most that a process has held, its libraries with it.",
        "Whole worlds hold every object's own sticks: Mitsuba 3.9.1 cannot instance in its JIT "
        "variants. A renderer that can would hold those of `meadow` in far less memory.",
    ),
)
