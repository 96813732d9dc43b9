"""The experiment `haze`."""
