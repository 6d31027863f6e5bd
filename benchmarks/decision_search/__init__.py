"""Search for the single set of decisions that fits the corridor's tables best."""
