"""The thesis's experiments, replicated: the same as `khepera-forage reproduce`."""

import sys

from khepera_forage.cli.main import main

if __name__ == "__main__":
    sys.exit(main(["reproduce", *sys.argv[1:]]))
