"""What the overhead camera reports."""
