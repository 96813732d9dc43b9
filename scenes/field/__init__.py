"""The endless field: Poisson cells, placed and posed species, traversal."""
