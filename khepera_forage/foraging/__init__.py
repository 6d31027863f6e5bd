"""The task, as pure functions: world to raw data to state vector to state to behaviour to motors."""
