"""``python -m roadmend.cli``."""

import sys

from roadmend.cli.main import main

sys.exit(main())
