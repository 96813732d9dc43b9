"""Memory that frames need: foretold, and the same for the last frame as for the first."""

import pytest

from bench.studies.memory import SCENES, memory_growth, predicted_memory, render_scene
from scenes.render.variants import JIT_VARIANT, works

pytestmark = pytest.mark.slow


@pytest.mark.parametrize("scene", [SCENES[0], SCENES[7]], ids=str)
def test_memory_is_foretold_within_a_quarter(scene: object) -> None:
    if (why := works(scene.variant)) is not True:
        pytest.skip(f"{scene.variant} does not work here: {why}")
    (record,) = render_scene(scene)
    assert 0.75 < predicted_memory(scene, record) / record["peak_rss_bytes"] < 1.25


def test_frame_after_frame_takes_no_more_memory() -> None:
    if works(JIT_VARIANT) is not True:
        pytest.skip("no LLVM here")
    early, late = memory_growth(30)
    assert late < 1.05 * early
