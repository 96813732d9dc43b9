"""How experiments are run and resumed."""
