"""The `khepera-forage` command."""

import argparse
import sys
from collections.abc import Sequence

from khepera_forage import __version__
from khepera_forage.cli import camera, recall, robot, teach, train, watch
from khepera_forage.rollouts.training import HopelessTraining
from khepera_forage.thesis import reproduce


def main(argv: Sequence[str] | None = None) -> int:
    """Run a subcommand; errors of the user's making are told in one line.

    Args:
        argv: Arguments; those of the process by default.

    Returns:
        Exit status: 0, or 2 for bad input.
    """
    parser = argparse.ArgumentParser(prog="khepera-forage", description="Learning to forage by imitation.")
    parser.add_argument("--version", action="version", version=f"khepera-forage {__version__}")
    subparsers = parser.add_subparsers(dest="command", required=True, metavar="command")
    for name, module, help_text in (
        ("reproduce", reproduce, "run the thesis' experiments and set the outcome beside its own"),
        ("train", train, "train a learner in the paired corridors and keep its experience"),
        ("teach", teach, "be the teacher yourself, with keys in a window"),
        ("recall", recall, "let a trained learner, or the teacher, forage alone"),
        ("watch", watch, "show a training or a recall as it happens, or save it as a film"),
        ("robot", robot, "try out a real Khepera, or start a virtual one"),
        ("camera", camera, "calibrate the overhead camera, see what it sees, or print the markers"),
    ):
        subparser = subparsers.add_parser(
            name, help=help_text, description=f"{help_text[:1].upper()}{help_text[1:]}."
        )
        module.add_arguments(subparser)
        subparser.set_defaults(run=module.run)
    arguments = parser.parse_args(argv)
    try:
        status: int = arguments.run(arguments)
    except (ValueError, OSError, ImportError, HopelessTraining) as error:
        print(f"khepera-forage {arguments.command}: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("stopped", file=sys.stderr)
        return 130
    return status


if __name__ == "__main__":
    sys.exit(main())
