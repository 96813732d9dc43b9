"""Fractal ground: relief, quadtree, mesh, colour."""
