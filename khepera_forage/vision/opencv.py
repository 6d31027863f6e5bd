"""OpenCV is an extra: what needs it asks here first, so that who has not installed it reads how to."""


def require_opencv(what: str) -> None:
    """Check that OpenCV can be imported.

    Args:
        what: Who needs it, for the message.

    Raises:
        ImportError: It cannot; the message says what to install.
    """
    try:
        import cv2  # noqa: F401 (whether it can be imported is the question)
    except ImportError as error:
        raise ImportError(f"{what} needs OpenCV: pip install 'khepera-forage[camera]' ({error})") from error
