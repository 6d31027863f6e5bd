"""Pictures of the environments: their content (`View`), drawing (`Renderer`), and animated GIFs (`save_gif`).

Importing this package needs neither pygame nor Pillow; drawing does (`pip install khepera-forage[render]`).
"""

from khepera_forage.envs.rendering.gif import save_gif
from khepera_forage.envs.rendering.renderer import Renderer
from khepera_forage.envs.rendering.view import FoodView, RobotView, View

__all__ = ["FoodView", "Renderer", "RobotView", "View", "save_gif"]
