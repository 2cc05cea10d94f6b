"""`python -m sbam.cli`."""

import sys

from sbam.cli import main

sys.exit(main())
