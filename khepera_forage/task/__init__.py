"""The foraging task, each rule once: perception, states, behaviours, steering, following, food, placement, score.

A round: `path_home_for` and `command` turn the behaviour into motors, the world advances, `perceive` makes raw data,
state vector and state of what the robot senses and the camera shows, and `end_step` accounts for it. `envs.forager` and
`envs.compiled.step` call them in this order.
"""
