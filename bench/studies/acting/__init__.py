"""What live actors cost, who may wait, and how they keep clear of each other."""
