"""Many fields in a file: what is kept of them, and how bands are judged."""

import numpy as np
import pytest

from bench.tone_benchmark import COLUMNS, bands_of, judged, kept, write


def planted(ratio: float, fields: int = 200) -> dict:
    """Fields of ``forest`` whose pruned bands are so bright beside the whole ones, give or take."""
    rng = np.random.default_rng(3)
    found = {}
    for seed in range(fields):
        rows = []
        for band in range(bands_of("forest")):
            rays, light = rng.integers(800, 1200, 2), 1e6 * rng.normal(1 + band, 0.05, 2)
            rows.append(
                [int(ratio * light[0] * rays[0]), rays[0], int(light[1] * rays[1]), rays[1]]
            )
        found["forest", seed] = [[int(each) for each in row] for row in rows]
    return found


@pytest.mark.parametrize(
    ("ratio", "verdict"), [(1.0, "holds"), (0.95, "refuted"), (1.05, "refuted")]
)
def test_bands_are_judged_by_what_was_planted(ratio, verdict):
    claims = judged(planted(ratio), "forest")
    assert [each.verdict for each in claims] == [verdict] * bands_of("forest")
    assert [each.measured for each in claims] == pytest.approx([ratio] * len(claims), abs=0.03)


def test_fields_are_kept_whole_or_not_at_all(tmp_path):
    path, found = tmp_path / "fields.csv", planted(1.0, 3)
    assert kept(path) == {}
    write(path, found)
    assert kept(path) == found
    text = path.read_text()
    assert text.splitlines()[0] == ",".join(COLUMNS)
    path.write_text(text[: text.rindex("forest")])  # the last band of the last field is missing
    assert kept(path) == {key: found[key] for key in sorted(found)[:2]}
    write(path, kept(path) | found)
    assert path.read_text() == text and list(tmp_path.iterdir()) == [path]
