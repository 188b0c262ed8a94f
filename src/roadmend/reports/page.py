"""Pages for a browser, made from the templates in this folder: one file each, and nothing but itself is needed to read it.

Whatever is put into a template is text and gets escaped; what is HTML already says so by its type, ``Markup``.
"""

import io
from functools import cache
from pathlib import Path

import matplotlib as mpl
from jinja2 import ChoiceLoader, Environment, FileSystemLoader, PackageLoader, StrictUndefined
from markupsafe import Markup
from matplotlib.figure import Figure


def render(template: str | Path, **values: object) -> str:
    """The text of a page.

    Args:
        template: name of a file in the folder ``templates``; or a file elsewhere, which may build upon those.
        values: by the names that the template gives them.

    Raises:
        jinja2.UndefinedError: the template asks for a name that has no value.
    """
    folder = template.parent if isinstance(template, Path) else None
    return _environment(folder).get_template(Path(template).name).render(**values)


def inline_svg(figure: Figure) -> Markup:
    """A figure as an element of the page; its texts stay texts, and equal figures are equal to the byte."""
    with io.StringIO() as buffer, mpl.rc_context({"svg.fonttype": "none", "svg.hashsalt": "roadmend"}):
        figure.savefig(buffer, format="svg", metadata={"Date": None})
        text = buffer.getvalue()
    return Markup(text[text.index("<svg") :])  # noqa: S704 - without the XML declaration; matplotlib escapes its texts


@cache
def _environment(folder: Path | None) -> Environment:
    ours = PackageLoader(__package__)
    environment = Environment(
        loader=ChoiceLoader([FileSystemLoader(folder), ours]) if folder is not None else ours,
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    environment.policies["json.dumps_kwargs"] = {"allow_nan": False, "separators": (",", ":")}
    return environment
