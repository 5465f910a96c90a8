"""Rigs for loops: free, with dry friction, and with a reaction wheel."""

FREE_TEXT = 'kind = "platform"\n[drive]\ngain = 0.4\n[axis]\ninertia = 0.1'
TESTBED_TEXT = (
    'kind = "reaction"\n[motor]\ntorque_constant = 0.0182\nresistance = 0.83\ninductance = 0.0641\nfriction = 4.07e-6\n'
    "[wheel]\ninertia = 1.24e-4\n[axis]\ninertia = 0.0495"
)
