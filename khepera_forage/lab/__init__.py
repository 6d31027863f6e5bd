"""Real robots under a real camera, or virtual ones: settings, devices, clock and operator."""
