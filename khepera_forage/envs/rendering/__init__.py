"""Pictures of the environments: what is shown (`View`), who draws it (`Renderer`), films of it (`save_gif`).

Importing this needs neither pygame nor Pillow; drawing does (`pip install khepera-forage[render]`).
"""

from khepera_forage.envs.rendering.gif import save_gif
from khepera_forage.envs.rendering.renderer import Renderer
from khepera_forage.envs.rendering.view import FoodView, RobotView, View

__all__ = ["FoodView", "Renderer", "RobotView", "View", "save_gif"]
