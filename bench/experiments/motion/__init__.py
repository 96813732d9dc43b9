"""The experiment `motion`."""
