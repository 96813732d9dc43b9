"""What stands for the hidden parts of an object: fitted by the program, for any part hierarchy."""
