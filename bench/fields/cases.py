"""Which cases does the scaling experiment sweep? One quantity of the law at a time (§4.1).

The ground is flat, the air is clear and an ideal eye looks all round; other cases, and those where
the law fails, are in ``bench.experiments.scaling.cases_beyond``. Densities are chosen per metric,
so that fields hold about as many objects whatever the metric's limit distance is.
"""

import math
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

EYE_HEIGHT_M = 1.6

SWEEPS = {
    "density": "K, objects per unit area",
    "size": "P + R, by scaling the species",
    "detail": "m, through the detail threshold τ",
    "resolution": "m, through the width of the picture",
    "magnification": "m, through the field of view",
    "world": "L, the side of the world",
}


@dataclass(frozen=True)
class Case:
    """One point of a sweep of one species, or of several as ``figure+rabbit``.

    density     K [1/m²]
    size        factor on every length of the species
    detail      τ [px]
    width       width of the picture [px]
    fov         its horizontal field of view [degrees]
    extent      side of the world [m]; None = endless
    eye_height  height of the eye above the ground under it [m]
    hills       amplitude of the ground [m]; 0 = flat
    visibility  V [m]; None = clear air
    gathered    how K varies: ``evenly``, the same everywhere; ``patches``, in one of four squares
                of side ``scale``; ``slope``, growing evenly to the east, K at the eye and twice
                that ``scale`` away; ``clearing``, growing with the distance from the eye as far as
                ``scale``, K at its edge
    scale       the length over which K varies [m]
    """

    sweep: str
    species: str
    metric: str
    density: float
    size: float = 1.0
    detail: float = 1.0
    width: int = 640
    fov: float = 60.0
    extent: float | None = None
    eye_height: float = EYE_HEIGHT_M
    hills: float = 0.0
    visibility: float | None = None
    gathered: str = "evenly"
    scale: float = 0.0

    @property
    def m(self) -> float:
        """The detail angle m = τ·2·tan(fov/2)/width [rad]."""
        return self.detail * 2 * math.tan(math.radians(self.fov) / 2) / self.width

    def as_json(self) -> dict[str, Any]:
        """Return plain data."""
        return asdict(self)


_DECADES = 2.02
"""A little more than two decades, so that whole pixels do not fall short of two."""


@dataclass(frozen=True)
class Setup:
    """What is swept for one species and metric, and how finely.

    density   K of every sweep [1/m²]; the sweep of K has it in its middle
    coarsest  largest m [rad]; the sweeps of m go two decades down from there
    world     a side of the world [m], about twice the limit distance in the world sweep
    steps     points in that many decades
    decades   of K, in the sweep of K
    """

    species: str
    metric: str
    sweeps: tuple[str, ...]
    density: float
    coarsest: float
    world: float
    steps: int
    decades: float = _DECADES


_ALL = tuple(SWEEPS)
_SOME = ("density", "size", "detail", "world")

SETUPS = (
    Setup("figure", "blake", _ALL, 3.6e-3, 0.045, 800.0, 7),
    # Parts of trees are so clumped that a point takes two million trees: one sweep.
    Setup("tree", "blake", ("density",), 5e-5, 0.045, 8800.0, 3),
    Setup("figure", "bounded", _SOME, 2.1e-2, 0.045, 340.0, 4),
    Setup("figure", "solid_angle", _SOME, 2.1e-2, 0.045, 340.0, 4),
    # Tufts of grass, from 10⁻⁴ to 10³ on a square metre, that are seen as far as 10 m.
    Setup("sward", "blake", ("density",), 10**-0.5, 0.62, math.inf, 5, 7.0),
    Setup("sward", "bounded", ("density",), 10**-0.5, 0.13, math.inf, 5, 7.0),
    Setup("sward", "solid_angle", ("density",), 10**-0.5, 0.13, math.inf, 5, 7.0),
)

WORLD_SIDES = (0.1, 0.25, 0.5, 0.75, 1.0, 1.5, 3, 10, 100, 1e3, 1e4, 1e6)
"""Sides of the world in units of ``Setup.world``, from well inside the limit to far outside."""


def cases() -> tuple[Case, ...]:
    """Return the whole grid; a quick run has the same points and fewer fields."""
    return tuple(
        case for setup in SETUPS for sweep in setup.sweeps for case in _sweep(setup, sweep)
    )


def metric_cases(name: str) -> tuple[Case, ...]:
    """Return the sweeps of another metric, like those of `bounded` and `solid_angle`."""
    setup = Setup("figure", name, _SOME, 2.1e-2, 0.045, 340.0, 4)
    return tuple(case for sweep in setup.sweeps for case in _sweep(setup, sweep))


def _sweep(setup: Setup, sweep: str) -> list[Case]:
    middle = _with_m(Case(sweep, setup.species, setup.metric, setup.density), setup.coarsest / 10)
    finer = np.geomspace(1.0, 10**-_DECADES, setup.steps) * setup.coarsest
    spread = setup.decades if sweep == "density" else _DECADES
    factors = np.geomspace(10 ** (-spread / 2), 10 ** (spread / 2), setup.steps)
    match sweep:
        case "density":
            return [replace(middle, density=float(setup.density * f)) for f in factors]
        case "size":
            return [replace(middle, size=float(f)) for f in factors]
        case "detail":
            return [_with_m(middle, m) for m in finer]
        case "resolution":
            one_pixel = replace(middle, detail=1.0)
            return [replace(one_pixel, width=round(_theta(1, middle.fov) / m)) for m in finer]
        case "magnification":
            return [_seen_through(middle, m, setup.coarsest) for m in finer]
        case "world":
            return [replace(middle, extent=float(setup.world * side)) for side in WORLD_SIDES]
    raise ValueError(sweep)


def _with_m(case: Case, m: float) -> Case:
    """Return the case with the detail threshold that gives this m."""
    return replace(case, detail=float(m / _theta(case.width, case.fov)))


def _seen_through(case: Case, m: float, coarsest: float) -> Case:
    """Return the case with a narrower field of view, like a magnifying glass, down to this m."""
    widest = 120.0
    detail = coarsest / _theta(case.width, widest)
    half = math.atan(m * case.width / (2 * detail))
    return replace(case, detail=float(detail), fov=math.degrees(2 * half))


def _theta(width: int, fov: float) -> float:
    return 2 * math.tan(math.radians(fov) / 2) / width
