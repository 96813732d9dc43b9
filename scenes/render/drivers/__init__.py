"""How a built scene is sampled, in each kind of variant."""
