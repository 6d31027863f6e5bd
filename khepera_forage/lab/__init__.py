"""Laboratories: real robots under a real camera, or virtual ones. Settings, devices, clock and operator."""
