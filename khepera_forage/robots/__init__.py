"""The Khepera in any embodiment: dimensions, senses, motors, infra-red model, serial driver and virtual robots."""
