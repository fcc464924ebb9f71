"""``python -m rosslt_auto``."""

import sys

from rosslt_auto.cli import main

if __name__ == "__main__":
    sys.exit(main())
