"""Sony's toio cubes on a printed mat: their driver on toio-py, and virtual cubes below toio-py's interface."""
