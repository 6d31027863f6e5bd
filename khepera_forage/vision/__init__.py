"""The overhead camera: scene, calibration, tracker, and simulated camera."""
