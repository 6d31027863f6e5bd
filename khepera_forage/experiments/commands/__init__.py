"""The smaller commands: camera, recall, robot, teach, train, watch. Each module has `add_arguments` and `run`."""

from khepera_forage.experiments.commands import camera, recall, robot, teach, train, watch

__all__ = ["camera", "recall", "robot", "teach", "train", "watch"]
