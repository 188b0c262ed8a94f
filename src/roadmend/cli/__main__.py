"""``python -m roadmend.cli``."""

import sys

from roadmend.cli.entry import main

if __name__ == "__main__":  # the forked nodes import this module under another name
    sys.exit(main())
