"""`khepera-forage camera`: calibrate the overhead camera, see what it sees, print the markers (3.4, 3.5)."""

import argparse

from khepera_forage.cli import camera_calibrate, camera_markers, camera_preview

_TASKS = (
    (
        "calibrate",
        camera_calibrate,
        "find where on the floor each point of the picture is, and write that down",
    ),
    ("preview", camera_preview, "show what a camera sees, with the regions that the tracker finds"),
    ("markers", camera_markers, "write a page with the robots' markers at true size, to print"),
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """A subcommand for each task."""
    tasks = parser.add_subparsers(dest="task", required=True, metavar="task")
    for name, module, help_text in _TASKS:
        task = tasks.add_parser(name, help=help_text, description=f"{help_text[:1].upper()}{help_text[1:]}.")
        module.add_arguments(task)
        task.set_defaults(run_task=module.run)


def run(arguments: argparse.Namespace) -> int:
    """Do the task.

    Raises:
        ValueError: A mistake in an argument, or a library that is not installed.
        OSError: A camera or file that cannot be used.
    """
    try:
        status: int = arguments.run_task(arguments)
    except ImportError as error:
        # It is the user's to mend, and the message says how.
        raise ValueError(str(error)) from error
    return status
