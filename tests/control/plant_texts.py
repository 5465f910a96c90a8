"""Rig files of a stiff motor and of a platform, as text."""

K, R, J, I, b = 0.0216, 36.3, 1.24e-4, 5e-4, 4e-6


def stiff(inductance: float, effects: str = "") -> str:
    """A reaction rig whose current is quick."""
    return (
        f'kind = "reaction"\n[motor]\ntorque_constant = {K}\nresistance = {R}\ninductance = {inductance}\nfriction = {b}\n'
        f"[wheel]\ninertia = {J}\n[axis]\ninertia = {I}\n[axis.friction]\nviscous = 1e-4\n{effects}"
    )


def platform(friction: str = "viscous = 0.02", effects: str = "") -> str:
    """A platform of 0.1 kg m2 and 0.4 N m/V."""
    return f'kind = "platform"\n[drive]\ngain = 0.4\n[axis]\ninertia = 0.1\n[axis.friction]\n{friction}\n{effects}'
