"""Part-whole actors, compound messages and quaternions, as the paper has them."""
