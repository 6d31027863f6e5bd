"""What a Khepera is and what its infra-reds read."""
