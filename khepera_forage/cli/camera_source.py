"""The cameras that the command line can open: devices, films, URLs, and a virtual one."""

import argparse
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from khepera_forage.vision.video import FrameSource

VIRTUAL = "virtual"


def add_source_arguments(parser: argparse.ArgumentParser) -> None:
    """Which camera, and the seed of a virtual one."""
    parser.add_argument(
        "--source",
        default="0",
        metavar="S",
        help="number of a device, film, URL, or `virtual`: a training in simulation, rendered (0)",
    )
    parser.add_argument("--seed", type=int, default=0, help="of a virtual camera (0)")


def open_source(arguments: argparse.Namespace, paced: bool) -> "FrameSource":
    """The camera asked for.

    Args:
        arguments: With `source` and `seed`.
        paced: Whether a virtual one keeps the pace of a real one.

    Raises:
        OSError: It cannot be opened.
        ImportError: OpenCV is not installed.
    """
    from khepera_forage.vision.opencv import require_opencv

    require_opencv("khepera-forage camera")
    if arguments.source == VIRTUAL:
        from khepera_forage.rollouts.rendered_training import RenderedTraining

        return RenderedTraining(arguments.seed, paced=paced)
    from khepera_forage.vision.video import VideoSource

    return VideoSource(arguments.source)
