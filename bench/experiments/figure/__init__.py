"""The experiment `figure`."""
