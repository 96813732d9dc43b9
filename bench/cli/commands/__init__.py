"""The commands of lodbench, one module each; what is heavy is imported inside them."""
