"""This package gives the ground the mean colour and cover of what is not displayed."""
