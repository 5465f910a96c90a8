"""Measured rigs whose label is withheld from the diagnosis."""
