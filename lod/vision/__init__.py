"""What a viewer resolves: the eye, its contrast sensitivity, and the blur before it."""
