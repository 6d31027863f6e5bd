"""Faults of robots, camera, cables and disk in the middle of trainings in the virtual laboratory."""
