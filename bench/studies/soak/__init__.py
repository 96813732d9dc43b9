"""What happens to folders of frames that are killed, damaged, shared and starved, for an hour."""
