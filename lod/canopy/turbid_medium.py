"""Plants as a turbid medium: the optical depth of what stands on the ground, by height.

Objects stand at random (Poisson), K of them to the square metre. A line at height z meets K·w(z) of
them a metre, w being the mean width of an object there, seen from the side; so of lines at the
elevation e exp(−K·ΔA/sin e) pass a layer in which each has the outline ΔA. This is Beer's law in a
stand of plants (Monsi & Saeki, "Über den Lichtfaktor in den Pflanzengesellschaften", Japanese
Journal of Botany 14, 1953; Nilson 1971, as in ``lod.canopy.gap_fraction``). Plants scatter a
share of the light, alike to all sides (isotropic leaf scattering: Ross, "The Radiation Regime
and Architecture of Plant Stands", 1981).
"""

from dataclasses import dataclass

import numpy as np

from lod.arrays import ArrayData, FloatArray


@dataclass(frozen=True, eq=False)
class Canopy(ArrayData):
    """The optical depth of standing objects by height, and their albedo.

    height  (steps + 1,) above the ground, from 0 up [m]
    depth   (steps,) K·ΔA of each step
    albedo  (bands,) share of the light met that goes on
    """

    height: FloatArray
    depth: FloatArray
    albedo: FloatArray

    @property
    def top_m(self) -> float:
        """Return the height of the highest object [m]; 0 where nothing stands."""
        return float(self.height[-1])


BARE = Canopy(np.zeros(1), np.zeros(0), np.zeros(3))
"""The canopy of bare ground."""
