"""The window of the "human" mode: the only thing here that touches a display."""

import pygame


class Window:
    """One window on the screen, and its pace.

    Attributes:
        dismissed: Whether somebody has closed it.
    """

    def __init__(self, fps: float) -> None:
        self.dismissed = False
        self._fps = fps
        self._clock = pygame.time.Clock()
        self._screen: pygame.Surface | None = None

    def show(self, picture: pygame.Surface, title: str) -> None:
        """Show a picture, then wait until its frame is over."""
        if self.dismissed:
            return
        if self._screen is None or self._screen.get_size() != picture.get_size():
            pygame.display.init()
            self._screen = pygame.display.set_mode(picture.get_size())
        pygame.display.set_caption(title or "khepera_forage")
        self._screen.blit(picture, (0, 0))
        pygame.display.flip()
        if any(event.type == pygame.QUIT for event in pygame.event.get()):
            self.close()
            self.dismissed = True
            return
        self._clock.tick(self._fps)

    def close(self) -> None:
        """Take the window off the screen."""
        if self._screen is not None:
            self._screen = None
            pygame.display.quit()
