"""The benchmark of repair methods on disk: JSON, Markdown and the page, complete or not at all."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from harness.benchmark_content import dump_json
from harness.benchmark_page import build_page
from harness.benchmark_tables import all_tables, headline
from roadmend.core.errors import InputError
from roadmend.core.markdown import table_text
from roadmend.core.whole_file import write_texts
from roadmend.reports.result_files import origin

TITLE = "Online repair of driving policies"


def write_benchmark(folder: Path, stem: str, content: Mapping[str, Any], cases: Mapping[str, Any]) -> None:
    """Write STEM.json, STEM-cases.json, STEM.md (the main table), STEM-tables.md (all tables) and STEM.html.

    Raises:
        InputError: the folder cannot be written.
    """
    made = origin(content["provenance"])
    main = table_text(headline(content))
    tables = "\n\n".join(table.markdown() for table in all_tables(content))
    write_texts(
        folder,
        {
            f"{stem}.json": dump_json(content) + "\n",
            f"{stem}-cases.json": dump_json(cases) + "\n",
            f"{stem}.md": f"# {TITLE}\n\n{main}\n\n{made}\n",
            f"{stem}-tables.md": f"# {TITLE}: all tables\n\n{tables}\n\n{made}\n",
            f"{stem}.html": build_page(content),
        },
    )


def read_json(path: Path) -> dict[str, Any]:
    """A file that the benchmark wrote.

    Raises:
        InputError: it is missing or damaged.
    """
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(str(path), f"cannot be read ({error})", "make it with 'roadmend bench adreft'") from None
    except ValueError:
        raise InputError(str(path), "is damaged", "make it again with 'roadmend bench adreft'") from None
    if not isinstance(content, dict):
        raise InputError(str(path), "is damaged", "make it again with 'roadmend bench adreft'")
    return content
