"""Diagnoses that are stopped at random moments, and what their answers are worth."""
