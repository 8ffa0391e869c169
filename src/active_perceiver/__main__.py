"""`python -m active_perceiver`."""

import sys

from active_perceiver.cli import main

sys.exit(main())
