"""Learning to forage by imitation: paired Khepera robots as PettingZoo and Gymnasium environments.

Importing the package registers `khepera_forage/Corridor-v1`, `Rectangle-v1`, `CorridorWheels-v1` and
`RectangleWheels-v1` with Gymnasium, and the same names with `-v0` for the decisions of version 0.1.
"""

from khepera_forage.envs.registration import register_all
from khepera_forage.noise import Noise
from khepera_forage.task.decisions import Decisions

__all__ = ["Decisions", "Noise", "__version__"]

__version__ = "0.2.0"

register_all()
