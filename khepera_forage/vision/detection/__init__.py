"""From the pixels of one frame to detections: threshold, markers with their holes, food, and what the floor shows."""
