"""This package is the endless field: Poisson cells, placed and posed species, traversal."""
