"""What motion of the image hides."""
