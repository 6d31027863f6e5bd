"""`khepera-forage camera`: calibrate the overhead camera, show its picture, print the markers (3.4, 3.5)."""

import argparse

from khepera_forage.cli.camera import calibrate, markers, preview
from khepera_forage.cli.subcommands import Subcommand, add_subcommands

SUBCOMMANDS = (
    Subcommand(
        "calibrate",
        "measure which point of the floor each pixel shows, and save that as a calibration file",
        calibrate.add_arguments,
        calibrate.run,
    ),
    Subcommand(
        "preview",
        "show the camera's picture with the regions that the tracker finds",
        preview.add_arguments,
        preview.run,
    ),
    Subcommand(
        "markers",
        "write a page with the robots' markers at true size, to print",
        markers.add_arguments,
        markers.run,
    ),
    Subcommand(
        "tags",
        "write pages with tags for robots, food and the floor at true size, to print",
        markers.add_tag_arguments,
        markers.run_tags,
    ),
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the subcommands."""
    add_subcommands(parser, "task", SUBCOMMANDS)
