"""The smaller commands: camera, robot, train, recall, watch. Each module has `add_arguments` and `run`."""

from khepera_forage.experiments.commands import camera, recall, robot, train, watch

__all__ = ["camera", "recall", "robot", "train", "watch"]
