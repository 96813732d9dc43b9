"""This package is the fractal ground: relief, quadtree, mesh, shading, and cover by far objects."""
