"""Learning to forage by imitation: paired Khepera robots as PettingZoo and Gymnasium environments.

Importing the package registers `khepera_forage/Corridor-v0`, `Rectangle-v0`, `CorridorWheels-v0` and
`RectangleWheels-v0` with Gymnasium.
"""

from khepera_forage.envs.registration import register_all
from khepera_forage.noise import Noise
from khepera_forage.task.decisions import Decisions

__all__ = ["Decisions", "Noise", "__version__"]

__version__ = "0.1.0"

register_all()
