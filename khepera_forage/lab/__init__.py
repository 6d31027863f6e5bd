"""Laboratories: real robots under a real camera, or virtual ones. Settings, devices, clock and operator.

Both need the extras `robots` and `camera`.
"""

from khepera_forage.extras import require

require("a laboratory", "robots", "camera")
