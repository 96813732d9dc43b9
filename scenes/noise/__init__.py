"""Counter-based random numbers and fractal noise on a lattice."""
