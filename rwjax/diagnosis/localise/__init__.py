"""Where the gap lies: missing torque, momentum, regimes and coordinates."""
