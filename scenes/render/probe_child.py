"""Render a tiny scene with one variant, in a process of its own: a libLLVM may abort it.

Run as a script by scenes/render/variants.py with the variant's name; prints "works" at the
end.
"""

import contextlib
import sys


def no_core_file() -> None:
    """An abort is an answer here, not something to debug."""
    with contextlib.suppress(ImportError):
        import resource

        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def tiny_scene(mi) -> dict:  # type: ignore[no-untyped-def]
    """A ball under the sky, in 4 × 4 pixels."""
    return {
        "type": "scene",
        "integrator": {"type": "path", "max_depth": 3},
        "sensor": {
            "type": "perspective",
            "to_world": mi.ScalarTransform4f().look_at([0, -4, 1], [0, 0, 0], [0, 0, 1]),
            "film": {"type": "hdrfilm", "width": 4, "height": 4, "rfilter": {"type": "box"}},
            "sampler": {"type": "multijitter", "sample_count": 4},
        },
        "sky": {"type": "sunsky", "sun_direction": [1, 0, 1]},
        "ball": {"type": "sphere", "bsdf": {"type": "diffuse"}},
    }


def main(variant: str) -> None:
    """Render it; raise unless its pixels sum to a positive finite number."""
    import mitsuba as mi

    mi.set_variant(variant)
    image = mi.TensorXf(mi.render(mi.load_dict(tiny_scene(mi)), seed=1))
    total = sum(float(value) for value in image.array)
    if not 0 < total < float("inf"):
        raise RuntimeError(f"the tiny scene came out wrong: its pixels sum to {total}")
    print("works")


if __name__ == "__main__":
    no_core_file()
    main(sys.argv[1])
