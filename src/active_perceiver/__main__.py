"""`python -m active_perceiver`."""

import sys

from active_perceiver.cli.main import main

sys.exit(main())
