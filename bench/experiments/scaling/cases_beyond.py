"""What does the law predict beyond even, flat, clear ground, and where does the bare one fail?

The bare law is πK((P + R)/m)² (§4.1). What it leaves out is swept here one quantity at a time, from
where it hardly matters to where it decides; the law with its terms for species, hills, K, eye
height and air predicts every case.
"""

from dataclasses import dataclass, replace

from bench.fields.cases import Case

_M = 0.0045
"""The detail angle of all sweeps but those of detail [rad]: the middle of the others' sweeps."""

_REACH_M = 400.0
"""The limit distance of a person at that angle, roughly [m]."""

_DENSITY = 3.6e-3
"""The density at which some 1800 people are within that distance [1/m²]."""


@dataclass(frozen=True)
class Question:
    """One sweep: its axis and its title in words, and the key of a case that it varies."""

    axis: str
    title: str
    key: str


BEYOND = {
    "mixed": Question("K, objects per m²", "Mixed species: people, trees and boulders", "density"),
    "hills": Question("amplitude of the ground (m)", "Hills", "hills"),
    "patches": Question("side of a patch (m)", "Clustered: objects in patches", "scale"),
    "slope": Question("where K is twice that at the eye (m)", "Graded: K grows one way", "scale"),
    "clearing": Question("radius of the clearing (m)", "Graded: an eye in a clearing", "scale"),
    "near": Question("m (rad), the limit near the eye", "The near field", "m"),
    "height": Question("height of the eye (m)", "A higher eye", "eye_height"),
    "haze": Question("m (rad), V = 2 km", "Haze", "m"),
}


def beyond_cases() -> tuple[Case, ...]:
    """Return every sweep, the mildest case first."""
    person = _at(Case("", "figure", "blake", _DENSITY), _M)
    several = replace(person, species="figure+tree+boulder")
    made = {
        "mixed": [replace(several, density=k * 1e-4) for k in (2.0, 8.0, 32.0)],
        "hills": [replace(person, hills=a) for a in (2.0, 8.0, 32.0, 128.0)],
        "patches": [_gathered(person, "patches", side) for side in (5.0, 20.0, 60.0)],
        "slope": [_gathered(person, "slope", far * _REACH_M) for far in (10.0, 3.0, 1.2)],
        "clearing": [_gathered(person, "clearing", r) for r in (20.0, 80.0, 320.0, 1280.0)],
        "near": [_reaching(person, far) for far in (32.0, 16.0, 8.0, 4.0, 2.5)],
        "height": [replace(person, eye_height=h) for h in (5.0, 40.0, 120.0, 240.0, 360.0)],
        "haze": [
            replace(_reaching(person, far * _REACH_M), visibility=2e3)
            for far in (0.5, 2.0, 8.0, 32.0)
        ],
    }
    return tuple(replace(case, sweep=sweep) for sweep, cases in made.items() for case in cases)


def swept_beyond(case: Case) -> float:
    """Return the quantity that the case's sweep varies."""
    return float(getattr(case, BEYOND[case.sweep].key))


def _at(case: Case, m: float) -> Case:
    """Return the case with the detail threshold that gives this m."""
    return replace(case, detail=case.detail * m / case.m)


def _reaching(case: Case, far_m: float) -> Case:
    """Return the case whose people are displayed up to about a distance, and are as many."""
    nearer = _REACH_M / far_m
    return replace(_at(case, _M * nearer), density=_DENSITY * nearer**2)


def _gathered(case: Case, how: str, scale: float) -> Case:
    return replace(case, gathered=how, scale=scale)
