"""What measures constants of the scenes."""
