"""What a Khepera is, in any embodiment."""
