"""A window for camera pictures; needs a display and pygame (extra `render`)."""

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    import pygame


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
        """Show a picture.

        Args:
            picture: Height x width x 3, red, green, blue.

        Returns:
            The clicks since the last picture, in pixels: u to the right, v down. The middle of the upper left pixel
            is (0.5, 0.5).
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
