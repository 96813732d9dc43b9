"""Films in which nothing should pop or stutter, and what motion does not explain of them."""
