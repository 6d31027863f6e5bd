"""The thesis's experiments, replicated: the same as `khepera-forage reproduce`."""

import argparse
import sys

from khepera_forage.cli import reproduce

if __name__ == "__main__":
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    reproduce.add_arguments(parser)
    sys.exit(reproduce.run(parser.parse_args()))
