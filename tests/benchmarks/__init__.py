"""The benchmark scripts, run as users run them."""
