"""The picture sources that the command line can open: devices, films, URLs, and a virtual camera."""

import argparse
from typing import TYPE_CHECKING

from khepera_forage.cli.arguments import add_seed_argument
from khepera_forage.extras import require

if TYPE_CHECKING:
    from khepera_forage.vision.video import FrameSource

VIRTUAL = "virtual"


def add_source_arguments(parser: argparse.ArgumentParser) -> None:
    """Add `--source`, and the `--seed` of a virtual camera."""
    parser.add_argument(
        "--source",
        default="0",
        metavar="S",
        help="number of a device, film file, URL, or `virtual` for rendered pictures of a simulated training (0)",
    )
    parser.add_argument("--size", type=_size, metavar="WxH", help="pixels of the camera's frames (640x480)")
    for name, what in (
        ("rate", "frames a second"),
        ("exposure", "exposure, off automatic"),
        ("focus", "focus, off automatic"),
    ):
        parser.add_argument(
            f"--{name}", type=float, metavar="N", help=f"{what}, of a device (its own setting)"
        )
    add_seed_argument(parser, "seed of the virtual camera")


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
        arguments: With `source` and `seed`.
        paced: Whether a virtual camera delivers frames in real time, and a file plays at its own speed.
        size: Of the frames, unless `--size` is given.

    Raises:
        OSError: The source cannot be opened.
        ImportError: OpenCV is not installed.
    """
    require("khepera-forage camera", "camera")
    if arguments.source == VIRTUAL:
        from khepera_forage.rollouts.rendered_training import RenderedTraining

        return RenderedTraining(arguments.seed, paced=paced)
    from khepera_forage.vision.video import VideoSettings, VideoSource

    settings = VideoSettings(arguments.size or size, arguments.rate, arguments.exposure, arguments.focus)
    return VideoSource(arguments.source, settings=settings, paced=paced)
