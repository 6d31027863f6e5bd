"""All learners side by side: the same as `khepera-forage compare`."""

import sys

from khepera_forage.cli.main import main

if __name__ == "__main__":
    sys.exit(main(["compare", *sys.argv[1:]]))
