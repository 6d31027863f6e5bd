"""Sine, cosine and arc tangent as polynomials: without calls and branches, so that loops over worlds vectorise.

Accurate to a few units in the last place of a float64, for angles up to some millions of turns.
"""

import math

from khepera_forage.compilation.decorators import inline

_QUARTER_HIGH, _QUARTER_LOW = 1.5707963267341256, 6.077100506506192e-11
"""pi / 2 in two parts. The last third of the first part's bits is 0, so that its whole multiples are exact."""


@inline
def cosine_sine(angle: float) -> tuple[float, float]:
    """Cosine and sine of an angle in radians (the polynomials of fdlibm on -pi/4..pi/4)."""
    turns = math.floor(angle * 0.6366197723675814 + 0.5)
    r = (angle - turns * _QUARTER_HIGH) - turns * _QUARTER_LOW
    z = r * r
    sine = r + r * z * (
        -1.66666666666666324348e-01
        + z
        * (
            8.33333333332248946124e-03
            + z
            * (
                -1.98412698298579493134e-04
                + z
                * (
                    2.75573137070700676789e-06
                    + z * (-2.50507602534068634195e-08 + z * 1.58969099521155010221e-10)
                )
            )
        )
    )
    cosine = (
        1.0
        - 0.5 * z
        + z
        * z
        * (
            4.16666666666666019037e-02
            + z
            * (
                -1.38888888888741095749e-03
                + z
                * (
                    2.48015872894767294178e-05
                    + z
                    * (
                        -2.75573143513906633035e-07
                        + z * (2.08757232129817482790e-09 - z * 1.13596475577881948265e-11)
                    )
                )
            )
        )
    )
    quarter = int(turns) & 3
    swapped = (quarter & 1) == 1
    c = sine if swapped else cosine
    s = cosine if swapped else sine
    return (-c if quarter == 1 or quarter == 2 else c), (-s if quarter >= 2 else s)


@inline
def direction(x: float, y: float) -> float:
    """Direction of a vector in radians, -pi..pi, 0 for none (the rational function of Cephes on -0.2..0.66)."""
    ax, ay = abs(x), abs(y)
    large, small = max(ax, ay, 1e-300), min(ax, ay)
    # atan(q) = pi/4 + atan((q - 1) / (q + 1)) above 0.66
    upper = small > 0.66 * large
    q = (small - large if upper else small) / (small + large if upper else large)
    z = q * q
    p = (
        ((-8.750608600031904122785e-1 * z - 1.615753718733365076637e1) * z - 7.500855792314704667340e1) * z
        - 1.228866684490136173410e2
    ) * z - 6.485021904942025371773e1
    d = (
        (((z + 2.485846490142306297962e1) * z + 1.650270098316988542046e2) * z + 4.328810604912902668951e2)
        * z
        + 4.853903996359136964868e2
    ) * z + 1.945506571482613964425e2
    angle = q * z * (p / d) + q + (0.7853981633974483 if upper else 0.0)
    angle = 1.5707963267948966 - angle if ay > ax else angle
    angle = 3.141592653589793 - angle if x < 0.0 else angle
    return -angle if y < 0.0 else angle
