"""Kinds of tree in tables, in the terms of Weber & Penn (1995).

Kinds of branches and crowns follow their tables (birch: quaking aspen; broadleaf: California black
oak and black tupelo); the values are our own, with far fewer branches, each of which bears a larger
leaf. What the terms mean is said in ``tree_kind``.
"""

import math

from scenes.models.trees.species import BranchLevel, Colour, Foliage, TreeSpecies
from scenes.sticks.view_dependence import ElevationTable


def _shades(dark: Colour, light: Colour, count: int = 5) -> tuple[Colour, ...]:
    """Colours from dark to light, evenly spaced in their logarithms."""
    steps = [k / (count - 1) for k in range(count)]
    pairs = list(zip(dark, light, strict=True))
    return tuple((_mixed(*pairs[0], s), _mixed(*pairs[1], s), _mixed(*pairs[2], s)) for s in steps)


def _mixed(a: float, b: float, share: float) -> float:
    return round(math.exp((1 - share) * math.log(a) + share * math.log(b)), 4)


BROADLEAF = TreeSpecies(
    name="broadleaf",
    height=(9.5, 0.8),
    trunk=0.68,
    radius=0.020,
    flare=0.55,
    below=0.35,
    trunk_wander=5.0,
    shape=((0.0, 0.88), (0.3, 1.0), (0.7, 0.97), (1.0, 0.82)),
    levels=(
        BranchLevel(11, 0.28, 0.62, 0.0, 68, 16, 137.5, 7, 0.40, 8, 3, 1.55),
        BranchLevel(7.0, 0.18, 0.56, 0.25, 58, 38, 140, 12, 0.20, 10, 2, 1.25),
        BranchLevel(7.0, 0.12, 0.52, 0.25, 54, 40, 140, 16, 0.05, 12, 2, 1.15),
    ),
    foliage=Foliage(leaves=14, length=0.15, wide=0.058, narrow=0.014, scatter=0.16, upturn=0.30),
    porous=(3, 3, 2, 1),
    wood=(1, 0, 0, 0),
    bark=((0.105, 0.080, 0.060), (0.135, 0.105, 0.075)),
    leafy={
        "spring": _shades((0.090, 0.170, 0.028), (0.190, 0.290, 0.060)),
        "summer": _shades((0.050, 0.100, 0.022), (0.132, 0.208, 0.044)),
        "autumn": _shades((0.190, 0.070, 0.015), (0.480, 0.300, 0.050)),
        "winter": (),
    },
    lit=(0.519, 0.68, 0.777, 0.86),
    lit_bare=(0.824, 0.942, 0.984),
    sides=(
        (1.18, 1.12, 1.03, 0.95, 0.9, 0.87, 0.87, 0.88, 0.9),
        (1.11, 1.07, 1.02, 0.98, 0.94, 0.92, 0.91, 0.91, 0.91),
        (1.06, 1.03, 1.0, 0.98, 0.96, 0.96, 0.96, 0.97, 0.97),
        (1.04, 1.02, 1.0, 0.98, 0.98, 0.98, 0.98, 0.98, 0.98),
    ),
    overlap=(0.35, 0.37, 0.44, 0.49),
    overlap_bare=(0.01, -0.35, -1.11),
)

BIRCH = TreeSpecies(
    name="birch",
    height=(11.0, 1.0),
    trunk=0.88,
    radius=0.0105,
    flare=0.35,
    below=0.35,
    trunk_wander=3.5,
    shape=((0.0, 0.75), (0.25, 1.0), (0.6, 0.75), (1.0, 0.25)),
    levels=(
        BranchLevel(16, 0.22, 0.30, 0.0, 50, 28, 140, 8, 0.15, 7, 4, 1.35),
        BranchLevel(7.0, 0.15, 0.55, 0.30, 48, 36, 140, 12, -0.55, 9, 3, 1.15),
        BranchLevel(6.0, 0.10, 0.62, 0.30, 46, 34, 140, 16, -1.00, 10, 2, 1.05),
    ),
    foliage=Foliage(leaves=11, length=0.085, wide=0.046, narrow=0.016, scatter=0.13, upturn=-0.35),
    porous=(4, 3, 2, 2),
    wood=(2, 0, 0, 1),
    bark=((0.560, 0.545, 0.510), (0.150, 0.105, 0.085)),
    leafy={
        "spring": _shades((0.110, 0.190, 0.035), (0.220, 0.310, 0.075)),
        "summer": _shades((0.070, 0.125, 0.030), (0.165, 0.230, 0.055)),
        "autumn": _shades((0.330, 0.210, 0.020), (0.620, 0.450, 0.060)),
        "winter": (),
    },
    thinnest=0.004,
    lit=(0.692, 0.801, 0.866, 0.935),
    lit_bare=(0.797, 0.959, 1.003),
    sides=(
        (1.02, 1.0, 0.99, 0.98, 0.97, 0.99, 1.02, 1.05, 1.06),
        (1.05, 1.03, 1.01, 1.0, 0.98, 0.96, 0.96, 0.95, 0.95),
        (1.04, 1.02, 1.01, 1.0, 0.99, 0.97, 0.96, 0.97, 0.97),
        (1.01, 1.0, 1.0, 1.0, 1.0, 0.99, 0.98, 0.99, 0.99),
    ),
    overlap=(0.49, 0.32, 0.35, 0.45),
    overlap_bare=(-0.13, -0.57, -1.35),
)

CONIFER = TreeSpecies(
    name="conifer",
    height=(13.0, 1.2),
    trunk=0.97,
    radius=0.0135,
    flare=0.40,
    below=0.35,
    trunk_wander=1.0,
    shape=((0.0, 0.92), (0.12, 1.0), (0.5, 0.60), (0.85, 0.24), (1.0, 0.09)),
    levels=(
        BranchLevel(58, 0.06, 0.225, 0.0, 98, 48, 137.5, 6, 0.10, 3, 3, 1.25),
        BranchLevel(11.5, 0.10, 0.50, 0.68, 58, 46, -1, 9, -0.22, 5, 2, 1.00),
    ),
    foliage=Foliage(
        leaves=15,
        length=0.29,
        wide=0.046,
        narrow=0.020,
        scatter=0.02,
        upturn=-0.10,
        flat=True,
        ahead=0.9,
    ),
    porous=(5, 4, 2),
    wood=(1, 0, 0),
    bark=((0.105, 0.085, 0.072), (0.100, 0.075, 0.055)),
    leafy={
        "spring": _shades((0.028, 0.062, 0.024), (0.105, 0.165, 0.045)),
        "summer": _shades((0.026, 0.056, 0.024), (0.070, 0.118, 0.046)),
        "autumn": _shades((0.026, 0.054, 0.024), (0.068, 0.108, 0.042)),
        "winter": _shades((0.024, 0.048, 0.026), (0.060, 0.094, 0.046)),
    },
    taper=0.93,
    clear=1,
    thinnest=0.004,
    lit=(0.663, 0.969, 1.01),
    sides=(
        (0.99, 0.96, 0.94, 0.94, 0.96, 1.03, 1.15, 1.28, 1.34),
        (1.02, 1.01, 1.0, 0.99, 0.99, 0.99, 1.0, 0.99, 0.99),
        (1.0, 1.0, 1.0, 0.99, 0.99, 1.0, 1.02, 1.02, 1.02),
    ),
    overlap=(0.13, 0.34, 0.53),
    heights=(
        ElevationTable(
            (0.68, 0.75, 0.88, 0.97, 1.0, 0.97, 0.88, 0.75, 0.67, 0.65),
            (0.63, 0.74, 0.86, 0.92, 0.94, 0.95, 0.96, 0.96, 1.0, 1.0),
        ),
        ElevationTable(
            (0.91, 0.86, 0.89, 0.94, 0.99, 1.0, 0.99, 0.97, 0.96, 0.95),
            (0.81, 0.83, 0.94, 0.97, 0.98, 1.0, 0.96, 0.94, 0.95, 0.95),
        ),
        ElevationTable(
            (0.81, 0.82, 0.86, 0.9, 0.94, 0.96, 0.96, 0.97, 0.99, 1.0),
            (0.88, 0.9, 0.96, 0.96, 0.99, 1.0, 0.99, 0.96, 0.98, 0.98),
        ),
    ),
)

SHRUB = TreeSpecies(
    name="shrub",
    height=(2.2, 0.25),
    trunk=0.10,
    radius=0.020,
    flare=0.0,
    below=0.15,
    trunk_wander=4.0,
    shape=((0.0, 0.85), (1.0, 1.0)),
    levels=(
        BranchLevel(10, 0.05, 7.0, 0.0, 46, 8, 137.5, 9, 0.35, 10, 4, 0.22),
        BranchLevel(8.0, 0.22, 0.42, 0.35, 50, 34, 140, 14, 0.35, 12, 2, 0.90),
        BranchLevel(3.4, 0.10, 0.60, 0.30, 50, 36, 140, 16, 0.10, 12, 2, 0.90),
    ),
    foliage=Foliage(leaves=9, length=0.062, wide=0.026, narrow=0.009, scatter=0.05, upturn=0.35),
    porous=(5, 4, 3, 2),
    wood=(0, 0, 0, 1),
    bark=((0.130, 0.100, 0.075), (0.150, 0.110, 0.080)),
    leafy={
        "spring": _shades((0.100, 0.180, 0.035), (0.210, 0.300, 0.070)),
        "summer": _shades((0.045, 0.095, 0.025), (0.120, 0.195, 0.050)),
        "autumn": _shades((0.210, 0.055, 0.018), (0.420, 0.200, 0.040)),
        "winter": (),
    },
    thinnest=0.003,
    lit=(0.549, 0.792, 0.885, 0.919),
    lit_bare=(0.866, 0.952, 0.978),
    sides=(
        (1.23, 1.17, 1.08, 0.98, 0.89, 0.83, 0.79, 0.78, 0.77),
        (1.03, 1.03, 1.0, 0.98, 0.97, 0.97, 0.99, 1.0, 1.0),
        (1.05, 1.04, 1.01, 0.98, 0.96, 0.96, 0.96, 0.97, 0.97),
        (1.04, 1.03, 1.01, 0.99, 0.97, 0.96, 0.96, 0.96, 0.96),
    ),
    overlap=(0.6, 0.27, 0.46, 0.59),
    overlap_bare=(0.02, -0.76, -1.17),
)

DEAD_TREE = TreeSpecies(
    name="dead tree",
    height=(8.5, 1.2),
    trunk=0.80,
    radius=0.024,
    flare=0.60,
    below=0.35,
    trunk_wander=7.0,
    shape=((0.0, 0.70), (0.3, 1.0), (0.7, 0.75), (1.0, 0.45)),
    levels=(
        BranchLevel(11, 0.30, 0.52, 0.0, 72, 24, 137.5, 10, 0.35, 13, 5, 1.30),
        BranchLevel(6.0, 0.20, 0.50, 0.30, 58, 40, 140, 16, 0.25, 16, 3, 1.25),
        BranchLevel(4.0, 0.20, 0.50, 0.30, 52, 40, 140, 18, 0.10, 18, 2, 1.15),
    ),
    foliage=None,
    porous=(7, 5, 4, 1),
    wood=(2, 2, 1, 1),
    bark=((0.270, 0.250, 0.225), (0.330, 0.310, 0.285)),
    leafy={},
    taper=0.70,
    clear=8,
    broken=0.45,
    thinnest=0.007,
    lit=(0.916, 1.009, 0.969),
    overlap=(0.0, -1.18, -4.15),
)

SPECIES = {each.name: each for each in (BROADLEAF, BIRCH, CONIFER, SHRUB, DEAD_TREE)}
