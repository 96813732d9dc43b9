"""The largest area that a few flat triangles cover, over all directions of view."""

from itertools import product

import numpy as np

from lod.arrays import Reals
from lod.errors import InputError
from lod.shapes import MeshTable

MOST_TRIANGLES = 12
"""Most triangles of one part; the work doubles with each."""


def largest_flat_areas(meshes: MeshTable) -> Reals:
    """Measure the largest area over directions that the mesh of each part covers, (n,) [m²].

    None of its triangles hides another. Triangles with normals a [m²], as long as their areas are
    large, then cover Σ |a·d| along the unit vector d, which is the support function of a zonotope.
    It is largest along the farthest corner Σ ±a, and all choices of signs are tried. A part without
    a mesh covers nothing.

    Raises InputError for a part of more than MOST_TRIANGLES.
    """
    corners = meshes.vertices[meshes.faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]) / 2
    largest = np.zeros(len(meshes.count))
    for triangles in np.unique(meshes.count[meshes.count > 0]):
        if triangles > MOST_TRIANGLES:
            raise InputError(
                "mesh", f"{triangles} triangles", f"at most {MOST_TRIANGLES} to a part"
            )
        parts = np.flatnonzero(meshes.count == triangles)
        rows = meshes.first_face[parts][:, None] + np.arange(triangles)
        signs = np.array([(1.0, *each) for each in product((1.0, -1.0), repeat=triangles - 1)])
        zonotope = np.einsum("sk,pkx->psx", signs, normals[rows])
        largest[parts] = np.linalg.norm(zonotope, axis=2).max(axis=1)
    return largest
