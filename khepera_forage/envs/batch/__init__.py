"""The task in thousands of worlds at once: bodies of `worlds.batch`, functions of `foraging`, compiled. Needs numba."""
