"""fbf: filtered B-splines vibration compensation for G-code machines."""

__version__ = "0.1.0"
