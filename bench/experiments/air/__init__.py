"""What does the experiment `air` ask, which functions answer it, and what is shown?"""

from bench.old_experiment import Experiment, functions_of

EXPERIMENT = Experiment(
    name="air",
    order=60,
    version=1,
    about=("haze as rendered: targets, the medium that scatters light, and spectral light"),
    question=(
        "Is the haze in the pictures what theory, a scattering medium and light of "
        "sixteen bands make of it?"
    ),
    full={"target_spp": {"scalar": 512, "jit": 512, "medium": 2048}, "seeds": 8},
    quick={"target_spp": {"scalar": 256, "jit": 256, "medium": 512}, "seeds": 4},
    expected_seconds={"full": 145.0, "quick": 80.0},
    **functions_of(__name__, "notes"),
    rendered=True,
    caveats=(
        "The airlight of the horizon's sky leaves out which way the sun stands to the air, "
        "that its glow varies with height, that it lies in the shade of what stands in it, and "
        "that it dims the light on its way to the ground. The scattered one has all that, with "
        "the shade of the mean stand, over ground that is level where a line of sight passes.",
        "The medium is a layer 10 m higher than the scene, under a sky that holds a whole "
        "atmosphere already; its phase function is one of clean continental air.",
        "RGB and spectral pictures also differ in the coefficients of the sky's model: the "
        "row of the sky shows by how much.",
    ),
)
