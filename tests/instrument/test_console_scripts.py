"""Wrappers that installers write, and what they wrap."""

from importlib import metadata

import pytest

from rosslt_auto.instrument.console_scripts import wrapped_package
from support.console_scripts import PIP, SETUP_PY

SCRIPT = PIP.format(module="demo_nodes.topics.talker")


def test_pip() -> None:
    assert wrapped_package(SCRIPT.encode()) == "demo_nodes"


def test_attribute_of_an_object() -> None:
    text = SCRIPT.replace("import main", "import App").replace("main()", "App.start()")
    assert wrapped_package(text.encode()) == "demo_nodes"


def test_setup_py_install() -> None:
    text = SETUP_PY.format(
        distribution=f"hypothesis=={metadata.version('hypothesis')}", name="hypothesis"
    )
    assert wrapped_package(text.encode()) == "hypothesis"


@pytest.mark.parametrize(
    "text",
    [
        SETUP_PY.format(distribution="nothing-of-this-name==1", name="nothing"),
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
