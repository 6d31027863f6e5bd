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
    add_seed_argument(parser, "seed of the virtual camera")


def open_source(arguments: argparse.Namespace, paced: bool) -> "FrameSource":
    """Open the picture source of `--source`.

    Args:
        arguments: With `source` and `seed`.
        paced: Whether a virtual camera delivers frames in real time.

    Raises:
        OSError: The source cannot be opened.
        ImportError: OpenCV is not installed.
    """
    require("khepera-forage camera", "camera")
    if arguments.source == VIRTUAL:
        from khepera_forage.rollouts.rendered_training import RenderedTraining

        return RenderedTraining(arguments.seed, paced=paced)
    from khepera_forage.vision.video import VideoSource

    return VideoSource(arguments.source)
