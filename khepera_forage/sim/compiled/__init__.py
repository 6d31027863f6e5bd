"""Simulated bodies compiled by numba: one robot, its food and a camera in each of many worlds. No task.

Needs numba (extra `fast`). `CompiledWorld` in `world` is one world; `stepping` has the kernels for blocks of worlds.
"""
