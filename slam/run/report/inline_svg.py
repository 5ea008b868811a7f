"""Figures as SVG inside a page: small, self-contained, in the colours of the page's theme."""

import re
from collections.abc import Mapping
from dataclasses import fields
from html import escape
from io import StringIO
from typing import Final

from markupsafe import Markup
from matplotlib import rc_context
from matplotlib.figure import Figure

from slam.run.pictures.figure_style import Palette, save_figure

_NAMES: Final = tuple(field.name for field in fields(Palette))
_STAND_INS: Final = {name: f"#0101{number:02x}" for number, name in enumerate(_NAMES, 1)}
"""Placeholder colours, each replaced by a CSS variable."""
THEMED: Final = Palette(**_STAND_INS)
"""Palette of the placeholders, for which the page sets the colours: ``--ink``, ``--slam`` ..."""


def inline_svg(figure: Figure, name: str, label: str) -> Markup:
    """Convert a figure drawn with THEMED; ``name`` is unique on the page, ``label`` is for screen readers.

    Texts stay texts, in the font of the page.
    """
    text = StringIO()
    with rc_context({"svg.fonttype": "none", "svg.hashsalt": name, "path.simplify_threshold": 0.3}):
        save_figure(figure, text, format="svg", transparent=True, metadata={"Date": None})
    return Markup(_cleaned(text.getvalue(), name, label))  # safe: matplotlib made it, and the label is escaped


def inline_figures(
    figures: Mapping[str, tuple[Figure | None, str]], key: str, of: str = ""
) -> list[tuple[Markup, str]]:
    """Convert figures, by name and with captions, to SVG with the caption; ``of`` follows the name in the label."""
    return [
        (inline_svg(figure, f"{key}-{name}", f"{name}{of}: {caption}"), caption)
        for name, (figure, caption) in figures.items()
        if figure is not None
    ]


def _cleaned(svg: str, name: str, label: str) -> str:
    svg = svg[svg.index("<svg") :]
    svg = re.sub(r"<metadata>.*?</metadata>", "", svg, flags=re.DOTALL)
    svg = re.sub(r' id="(?!p|m|image|[CD][0-9_])[^"]*"', "", svg)  # drop ids of groups, which are not used
    svg = re.sub(r' id="', f' id="{name}-', svg)
    svg = re.sub(r'(url\(#|xlink:href="#)', rf"\1{name}-", svg)
    for variable, colour in _STAND_INS.items():
        svg = svg.replace(colour, f"var(--{variable})")
    size = re.search(r'width="[^"]*pt" height="[^"]*pt"', svg)
    return svg.replace(size[0] if size else "", f'role="img" aria-label="{escape(label)}"', 1)
