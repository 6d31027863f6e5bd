"""The window of the render mode "human": the only module here that uses a display."""

import pygame


class Window:
    """One window, opened by the first picture.

    Attributes:
        closed_by_user: Whether the user closed the window.
    """

    def __init__(self, fps: float) -> None:
        self.closed_by_user = False
        self._fps = fps
        self._clock = pygame.time.Clock()
        self._surface: pygame.Surface | None = None

    def show(self, picture: pygame.Surface, title: str) -> None:
        """Show a picture, then wait until the next one is due."""
        if self.closed_by_user:
            return
        if self._surface is None or self._surface.get_size() != picture.get_size():
            pygame.display.init()
            self._surface = pygame.display.set_mode(picture.get_size())
        pygame.display.set_caption(title or "khepera_forage")
        self._surface.blit(picture, (0, 0))
        pygame.display.flip()
        if any(event.type == pygame.QUIT for event in pygame.event.get()):
            self.close()
            self.closed_by_user = True
            return
        self._clock.tick(self._fps)

    def close(self) -> None:
        """Close the window."""
        if self._surface is not None:
            self._surface = None
            pygame.display.quit()
