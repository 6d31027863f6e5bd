"""Picture sources that the commands open (devices, films, URLs, a virtual camera), and a window for pictures."""

import argparse
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from khepera_forage.cli.options import option, seed
from khepera_forage.extras import require
from khepera_forage.vision.scene import MM_PER_PIXEL, Scene

if TYPE_CHECKING:
    import pygame

    from khepera_forage.vision.video import FrameSource

VIRTUAL = "virtual"


def _size(text: str) -> tuple[int, int]:
    width, times, height = text.lower().partition("x")
    if not (times and width.isdecimal() and height.isdecimal()):
        raise argparse.ArgumentTypeError(f"{text!r}; allowed: width x height in pixels, such as 1280x720")
    return int(width), int(height)


def open_source(
    arguments: argparse.Namespace, paced: bool, size: tuple[int, int] | None = None
) -> "FrameSource":
    """Open the picture source of `--source`.

    Args:
        arguments: As parsed with `SOURCE`.
        paced: Whether a virtual camera delivers frames in real time, and a file plays at its own speed.
        size: Of the frames, unless `--size` is given.
    """
    require("khepera-forage camera", "camera")
    if arguments.source == VIRTUAL:
        from khepera_forage.rollouts.rendered_training import RenderedTraining

        return RenderedTraining(arguments.seed, paced=paced)
    from khepera_forage.vision.video import VideoSettings, VideoSource

    settings = VideoSettings(arguments.size or size, arguments.rate, arguments.exposure, arguments.focus)
    return VideoSource(arguments.source, settings=settings, paced=paced)


SOURCE = (
    option(
        "--source",
        default="0",
        metavar="S",
        help="number of a device, film file, URL, or `virtual` for rendered pictures of a simulated training (0)",
    ),
    option("--size", type=_size, metavar="WxH", help="pixels of the camera's frames (640x480)"),
    *(
        option(f"--{name}", type=float, metavar="N", help=f"{what}, of a device (its own setting)")
        for name, what in (
            ("rate", "frames a second"),
            ("exposure", "exposure, off automatic"),
            ("focus", "focus, off automatic"),
        )
    ),
    seed("seed of the virtual camera"),
)


class PictureWindow:
    """A window that shows one picture after the other and reports mouse clicks.

    Attributes:
        closed: Whether the user closed the window or pressed Escape.
    """

    def __init__(self, screen: "pygame.Surface") -> None:
        self.closed = False
        self._screen = screen

    @classmethod
    def open(cls, title: str, width: int, height: int) -> "PictureWindow | None":
        """Open a window; None if there is no display or no pygame."""
        try:
            import pygame
        except ImportError:
            return None
        from khepera_forage.envs.rendering.output import open_display

        try:
            open_display()
            screen = pygame.display.set_mode((width, height))
        except (OSError, pygame.error):
            return None
        pygame.display.set_caption(title)
        return cls(screen)

    def show(self, picture: NDArray[np.uint8]) -> list[tuple[float, float]]:
        """Show a picture of height x width x 3 (red, green, blue), and return the clicks since the last one.

        They are in pixels: u to the right, v down. The middle of the upper left pixel is (0.5, 0.5).
        """
        import pygame

        surface = pygame.surfarray.make_surface(picture.swapaxes(0, 1))
        self._screen.blit(surface, (0, 0))
        pygame.display.flip()
        clicks = []
        for event in pygame.event.get():
            if event.type == pygame.QUIT or (event.type == pygame.KEYDOWN and event.key == pygame.K_ESCAPE):
                self.closed = True
            elif event.type == pygame.MOUSEBUTTONDOWN and event.button == 1:
                clicks.append((event.pos[0] + 0.5, event.pos[1] + 0.5))
        return clicks

    def title(self, text: str) -> None:
        """Change the text of the title bar."""
        import pygame

        pygame.display.set_caption(text)

    def close(self) -> None:
        """Close the window."""
        import pygame

        pygame.display.quit()


def described(scene: Scene, markers: str = "holes") -> str:
    """One line of text: the kind, position in mm and orientation of each region."""
    if not scene.regions:
        return "nothing seen"
    words = []
    for region in scene.regions:
        marker = f"{region.holes}-hole marker" if markers == "holes" else f"marker {region.holes}"
        what = marker if region.holes else "food"
        where = f"({region.x * MM_PER_PIXEL:.0f}, {region.y * MM_PER_PIXEL:.0f}) mm"
        facing = f" {region.orientation} deg" if region.holes else ""
        words.append(f"{what} {where}{facing}{'' if region.found else ' lost'}")
    return ", ".join(words)
