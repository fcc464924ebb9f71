"""Values that instrumented programs read from files."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from rosslt_auto.provenance import refresh
from rosslt_auto.provenance.registry import location_of
from rosslt_auto.provenance.values import is_tracked

pytest.importorskip("yaml")

READERS = {
    "json.load": "import json\nwith open(PATH) as f:\n    d = json.load(f)\n",
    "json.loads": "import json\nwith open(PATH) as f:\n    d = json.loads(f.read())\n",
    "load": "from json import load\nwith open(PATH) as f:\n    d = load(f)\n",
    "loads": "from json import loads as parse\nimport pathlib\n"
    "d = parse(pathlib.Path(PATH).read_text())\n",
    "safe_load": "import yaml\nwith open(PATH) as f:\n    d = yaml.safe_load(f)\n",
    "yaml.load": "import yaml\nd = yaml.load(open(PATH), Loader=yaml.SafeLoader)\n",
}


@pytest.mark.parametrize("reader", READERS)
def test_a_value_of_a_file_is_a_location(
    reader: str, tmp_path: Path, instrumented: Callable[..., dict[str, Any]]
) -> None:
    path = tmp_path / f"mission_{reader.replace('.', '_')}.json"
    path.write_text('{"speed": 0.5, "points": [1, 2]}\n')
    names = instrumented(
        f"PATH = {str(path)!r}\n{READERS[reader]}\nx = d['speed'] * 2\n",
        name=f"reads_{reader.replace('.', '_')}",
    )
    assert names["d"] == {"speed": 0.5, "points": [1, 2]}
    assert names["x"] == 1.0
    assert is_tracked(names["x"])
    location = location_of(f"rosslt.reads_{reader.replace('.', '_')}.{path.stem}.speed")
    assert location is not None
    refresh.apply({location: 0.75})
    assert json.loads(path.read_text()) == {"speed": 0.75, "points": [1, 2]}
