"""Kinds of plumes: the numbers that make smoke and flames."""

from dataclasses import dataclass

from lod.errors import InputError

PARTICLES_PER_BALL = 8
"""Particles that one larger ball replaces in a puff's leaf appearance."""

SHORTEST_LIFE = 0.75
"""Shortest life of a puff, as a share of the longest."""


@dataclass(frozen=True)
class PlumeKind:
    """Numbers of one kind of plume; lengths are of a plume of size 1.

    rate       puffs born in a second; life_s: longest life of one [s]
    particles  in a puff, a multiple of PARTICLES_PER_BALL
    height     to which a puff rises in its life [m]; lean: how far the wind takes it meanwhile [m]
    mouth      radius in which puffs are born [m]; wander: radius of their winding at the end [m]
    young, old radius of a puff at birth and at the end [m]
    grain      radius of a particle beside its puff's, at its largest
    stretch    its half length beside its radius: 1 = a ball
    colours    (k, 3) from birth to death: albedo, or radiance where it glows
    glows      whether it is a flame, which gives light and is bounded by triangles
    """

    rate: float
    life_s: float
    particles: int
    height: float
    lean: float
    mouth: float
    wander: float
    young: float
    old: float
    grain: float
    stretch: float
    colours: tuple[tuple[float, float, float], ...]
    glows: bool = False

    def __post_init__(self) -> None:
        if self.particles % PARTICLES_PER_BALL or self.particles < PARTICLES_PER_BALL:
            raise InputError("particles", self.particles, f"a multiple of {PARTICLES_PER_BALL}")
        if not (self.grain > 0 and self.stretch >= 1):
            raise InputError("grain, stretch", (self.grain, self.stretch), "above 0; 1 or more")
        if not self.rate * self.life_s * SHORTEST_LIFE >= 2:
            rule = "births a second such that one puff at least is always alive"
            raise InputError("rate", self.rate, rule, f"try {4 / self.life_s:.3g}")

    @property
    def widest(self) -> float:
        """Return the largest radius of a puff [m]."""
        return max(self.young, self.old)


SMOKE = PlumeKind(
    rate=5.0,
    life_s=9.0,
    particles=240,
    height=13.0,
    lean=5.0,
    mouth=0.12,
    wander=0.7,
    young=0.16,
    old=1.5,
    grain=0.03,
    stretch=1.0,
    colours=((0.16, 0.15, 0.14), (0.30, 0.30, 0.30), (0.42, 0.42, 0.43)),
)
"""Smoke of a wood fire in light wind; chosen by eye."""

FLAMES = PlumeKind(
    rate=26.0,
    life_s=0.9,
    particles=32,
    height=1.05,
    lean=0.14,
    mouth=0.24,
    wander=0.07,
    young=0.15,
    old=0.05,
    grain=0.13,
    stretch=3.0,
    colours=((0.9, 0.22, 0.02), (0.7, 0.12, 0.008), (0.45, 0.05, 0.002), (0.2, 0.012, 0.0005)),
    glows=True,
)
"""Flames of a campfire, hotter below. Radiance in the units of the sky at dusk, chosen by eye."""

KINDS = {"smoke": SMOKE, "flames": FLAMES}
