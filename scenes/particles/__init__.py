"""This package has plumes of particles: smoke and flames."""
