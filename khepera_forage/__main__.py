"""`python -m khepera_forage` is the `khepera-forage` command."""

import sys

from khepera_forage.cli.main import main

if __name__ == "__main__":
    sys.exit(main())
