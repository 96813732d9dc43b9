"""How pictures are compared, and the scenes in which pruning is."""
