"""The foraging task, each rule once: perception, states, behaviours, steering, following, food, placement, score."""
