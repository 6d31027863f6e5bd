"""Pictures of the environments: their content (`View`), where they go (`Screen`), and films (`save_film`).

Importing this package needs neither pygame nor Pillow; drawing does (`pip install khepera-forage[render]`).
"""

from khepera_forage.envs.rendering.output import RENDER_MODES, Screen, save_film
from khepera_forage.envs.rendering.view import FoodView, RobotView, View, recall_view, training_view

__all__ = ["RENDER_MODES", "FoodView", "RobotView", "Screen", "View", "recall_view", "save_film", "training_view"]
