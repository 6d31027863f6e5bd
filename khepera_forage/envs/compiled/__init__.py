"""The task in thousands of worlds at once: bodies of `sim.compiled`, functions of `foraging`, compiled. Needs numba."""
