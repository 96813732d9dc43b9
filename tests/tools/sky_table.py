"""Write the light of the sky by direction: ``python -m tests.tools.sky_table``.

The table ``scenes/appearance/sky.csv`` holds the radiance of Mitsuba's ``sunsky`` by
turbidity, elevation of the sun and cells of directions, the mean over the solid angle of each, in
red, green and blue, over what white level ground sends in the light of sun and sky. The two sides
of the sun are alike.
"""

from collections.abc import Iterator
from importlib import resources
from itertools import product
from pathlib import Path

import numpy as np
from jaxtyping import Float64

from scenes.appearance.sky import (
    ELEVATIONS_DEG,
    SKY_COLUMNS,
    SKY_ROWS,
    TURBIDITIES,
    cell_irradiance,
)
from scenes.render.light import sky_radiance, sun_irradiance
from scenes.render.variants import SCALAR_VARIANT, use

FINER = 12
"""Directions along each side of a cell."""

HEADS = "turbidity,elevation,rise,turn,red,green,blue"

Cells = Float64[np.ndarray, "r t 3"]


def cells(elevation_deg: float, turbidity: float, finer: int = FINER) -> Cells:
    """Radiance of each cell over that of white level ground, (SKY_ROWS, SKY_COLUMNS, 3), in the
    variant that is set."""
    height = np.radians(elevation_deg)
    to_sun = np.array((np.cos(height), 0.0, np.sin(height)))
    light = {"to_sun": to_sun, "turbidity": turbidity}
    rise, turn = ((np.arange(n * finer) + 0.5) / (n * finer) for n in (SKY_ROWS, SKY_COLUMNS))
    z, a = (each.ravel() for each in np.meshgrid(rise, np.pi * turn, indexing="ij"))
    level = np.sqrt(1 - z**2)
    sky = sky_radiance(light, np.column_stack((level * np.cos(a), level * np.sin(a), z)))
    found: Cells = sky.reshape(SKY_ROWS, finer, SKY_COLUMNS, finer, 3).mean(axis=(1, 3))
    white = cell_irradiance() @ found.reshape(-1, 3) + sun_irradiance(light) * to_sun[2] / np.pi
    return found / white


def rows() -> Iterator[str]:
    """Lines of the file."""
    yield HEADS
    for turbidity, elevation in product(TURBIDITIES, ELEVATIONS_DEG):
        for (rise, turn), each in zip(
            np.ndindex(SKY_ROWS, SKY_COLUMNS),
            cells(elevation, turbidity).reshape(-1, 3),
            strict=True,
        ):
            colour = ",".join(f"{value:.4g}" for value in each)
            yield f"{turbidity:g},{elevation:g},{rise},{turn},{colour}"


def main() -> None:
    """Write the file anew."""
    use(SCALAR_VARIANT)
    path = Path(str(resources.files("scenes.appearance") / "sky.csv"))
    path.write_text("\n".join(rows()) + "\n", encoding="ascii")


if __name__ == "__main__":
    main()
