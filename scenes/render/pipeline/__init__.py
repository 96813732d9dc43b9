"""One frame from its input to its layers."""
