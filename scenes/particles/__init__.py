"""Plumes of particles: smoke and flames."""
