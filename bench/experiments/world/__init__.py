"""The experiment `world`."""
