"""This package has counter-based random numbers, and fractal noise on a lattice."""
