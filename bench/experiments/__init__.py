"""The experiments: each file is one, and is found by being here (``bench.experiment``)."""
