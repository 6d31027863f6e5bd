"""Under the driver of a real Khepera: its port, who owns it, what passes for an answer, and how it is stopped."""
