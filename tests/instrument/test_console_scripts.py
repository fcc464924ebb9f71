"""Wrappers that installers write, and what they wrap."""

from importlib import metadata

import pytest

from rosslt_auto.instrument.console_scripts import wrapped_package

PIP = """#!/usr/bin/python3
# -*- coding: utf-8 -*-
import re
import sys
from demo_nodes.topics.talker import main
if __name__ == '__main__':
    sys.argv[0] = re.sub(r'(-script\\.pyw|\\.exe)?$', '', sys.argv[0])
    sys.exit(main())
"""

COLCON = """#!/usr/bin/python3
# EASY-INSTALL-ENTRY-SCRIPT: '{0}','console_scripts','{1}'
import re, sys
__requires__ = '{0}'
try:
    from importlib.metadata import distribution
except ImportError:
    from pkg_resources import load_entry_point
"""


def test_pip() -> None:
    assert wrapped_package(PIP.encode()) == "demo_nodes"


def test_attribute_of_an_object() -> None:
    text = PIP.replace("import main", "import App").replace("main()", "App.start()")
    assert wrapped_package(text.encode()) == "demo_nodes"


def test_setup_py_install() -> None:
    text = COLCON.format(f"hypothesis=={metadata.version('hypothesis')}", "hypothesis")
    assert wrapped_package(text.encode()) == "hypothesis"


@pytest.mark.parametrize(
    "text",
    [
        COLCON.format("nothing-of-this-name==1", "nothing"),
        "import sys\nfrom json import main\nif __name__ == '__main__':\n    sys.exit(main())",
        "from pkg import main\nx = 1\nif __name__ == '__main__':\n    main()",
        "from pkg import other\nif __name__ == '__main__':\n    main()",
        "import rclpy\nclass Node: pass\nif __name__ == '__main__': main()",
        "this is no Python",
        "",
    ],
)
def test_no_wrapper(text: str) -> None:
    assert wrapped_package(text.encode()) is None
