import json

import numpy as np
import pytest

from bench.observers import make
from bench.observers.plan import FITTED_LEVELS, SMALL_SET
from scenes.render.pictures import ffmpeg_path

SIZE = 96, 64


def grey_condition(condition, folder, how):
    """An entry of the plan whose pictures are grey, and darker where more is pruned."""
    ends = ".webm" if condition.moving else ".png"

    def written(name, shade):
        path = folder / make.PICTURES / f"{condition.name.replace(', ', '-')}-{name}{ends}"
        make.write_clip([np.full((SIZE[1], SIZE[0], 3), shade, np.uint8)] * 3, path)
        return f"{make.PICTURES}/{path.name}"

    levels = [written(f"level-{k}", 150 - 10 * k) for k in range(len(FITTED_LEVELS))]
    model = [0.0025 * k for k in range(len(FITTED_LEVELS) - 1)]
    names = {name: written(name, 150) for name in ("reference", "again")}
    said = {"flip": model, "barten": [200 * each for each in model]}
    about = {"name": condition.name, "moving": condition.moving}
    return about | names | {"levels": levels, "models": said, "seconds": 1.0}


@pytest.fixture(scope="session")
def experiment(tmp_path_factory):
    """The folder of an experiment of six conditions, as `observe make` leaves it."""
    if ffmpeg_path() is None:
        pytest.skip("ffmpeg is not installed")
    folder = tmp_path_factory.mktemp("experiment")
    how = make.Pictures("x".join(map(str, SIZE)), 1, 3)
    fake = lambda _, cases: (grey_condition(*case) for case in cases)  # noqa: E731
    make.make(folder, SMALL_SET, how, fake, lambda *_: None, [])
    return folder


@pytest.fixture(scope="session")
def plan(experiment):
    return json.loads((experiment / make.PLAN).read_text("utf-8"))
