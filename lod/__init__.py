"""The theory: part hierarchies, the metric family, the pruner and the law's predictions.

Nothing in this package opens a file, reads a clock or imports a renderer. A § without a name is a
section of Blake, "A Metric for Computing Adaptive Detail in Animated Scenes using Object-Oriented
Programming" (Eurographics 1987). Lengths are in metres and angles in radians where nothing else is
said, x points east, y north and z up. ``docs/method.md`` explains how the law is tested, and the
words and symbols that stand in every module. Beside those:

    θ     angle of one pixel, or the full width of all blurs together [rad] (§2.1)
    C₀    inherent contrast of a part with its surroundings, seen through no air
    W(d)  weighted distance: the distance in clear air at which as little is seen as at d [m]
"""
