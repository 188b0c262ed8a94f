"""src/doc/parameters.md names what the nodes declare, all of it and nothing else."""

import importlib.util
from pathlib import Path


def test_the_page_is_what_the_nodes_would_write():
    path = Path(__file__).with_name("parameter_page.py")
    spec = importlib.util.spec_from_file_location("parameter_page", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    with module.apart():
        written = module.page()
    assert written == module.PAGE.read_text(encoding="utf-8"), f"write it anew: python tests/nodes/{path.name} --write"
