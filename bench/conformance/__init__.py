"""Rules that every representation and metric keeps."""
