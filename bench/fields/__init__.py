"""Fields that several experiments measure."""
