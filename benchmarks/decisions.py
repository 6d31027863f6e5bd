"""Which readings of the thesis do its own tables support? The same as `khepera-forage infer`."""

import sys

from khepera_forage.cli.main import main

if __name__ == "__main__":
    sys.exit(main(["infer", *sys.argv[1:]]))
