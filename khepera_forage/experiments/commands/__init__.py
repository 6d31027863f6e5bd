"""The smaller commands: train, recall, watch. Each module has `add_arguments` and `run`."""

from khepera_forage.experiments.commands import recall, train, watch

__all__ = ["recall", "train", "watch"]
