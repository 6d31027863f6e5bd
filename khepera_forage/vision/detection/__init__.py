"""Detection in single frames: segmentation, markers with their holes, food, and whether the floor is visible."""
