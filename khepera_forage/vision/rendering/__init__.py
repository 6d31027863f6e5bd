"""What a rendered frame is drawn with: the look of a camera, its light, pen and cables; and the markers to print."""
