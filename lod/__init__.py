"""The theory: part hierarchies, the metric family, the pruner and the law's predictions.

Nothing in this package opens a file, reads a clock or imports a renderer. A § without a name is a
section of Blake, "A Metric for Computing Adaptive Detail in Animated Scenes using Object-Oriented
Programming" (Eurographics 1987). Lengths are in metres and angles in radians where nothing else is
said, x points east, y north and z up. ``docs/method.md`` explains how the law is tested.

Words:
    whole, part     A whole owns parts, which may be wholes of their own; the root is the whole
                    object, and together they are its hierarchy (§2.3).
    level           depth in the hierarchy at which a part is modelled; 0 is one blob
    leaf appearance what a part looks like while none of its own parts is displayed (§2.4); its
                    inner appearance is what it adds to its displayed parts
    cut             the parts displayed in one frame: a connected top of every object's hierarchy
    limit distance  the distance D within which a part is displayed
    law             the predicted number of parts displayed in a random field (§4.1)

Symbols:
    P     priority: √ of the largest cross-section that the leaf appearance can present [m] (§2.4)
    R     range: how far the part's extremes and its parts' ends can be from its origin [m] (§2.4)
    B     bound: radius about the part's origin that holds everything in it, in any pose [m]
    d     distance from the eye to the part's origin [m]
    θ     angle of one pixel, or the full width of all blurs together [rad] (§2.1)
    τ     detail threshold [px]
    m     τ·θ: the least angle at which a part is displayed [rad] (§2.4)
    D     limit distance: a part is displayed while d < D; (P + R)/m for ``blake`` [m]
    K     density: objects of a species per unit of ground [1/m²]
    C₀    inherent contrast of a part with its surroundings, seen through no air
    β, V  extinction of the haze [1/m], and visibility V = 3.912/β [m]
    W(d)  weighted distance: the distance in clear air at which as little is seen as at d [m]
"""
