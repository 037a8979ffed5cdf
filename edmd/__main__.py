"""`python -m edmd` is the command line."""

import sys

from edmd.cli import main

sys.exit(main())
