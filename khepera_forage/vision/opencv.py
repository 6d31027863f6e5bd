"""Check for OpenCV, an optional dependency, with an error that says what to install."""


def require_opencv(feature: str) -> None:
    """Check that OpenCV can be imported.

    Args:
        feature: What needs OpenCV, for the message.

    Raises:
        ImportError: OpenCV cannot be imported; the message says what to install.
    """
    try:
        import cv2  # noqa: F401 (only whether it can be imported matters)
    except ImportError as error:
        raise ImportError(
            f"{feature} needs OpenCV: pip install 'khepera-forage[camera]' ({error})"
        ) from error
