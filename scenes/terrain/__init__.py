"""This package is the fractal ground: relief, quadtree, mesh and colour."""
