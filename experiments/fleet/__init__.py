"""Simulated fleets with withheld wear, and what a fleet of a size costs."""
