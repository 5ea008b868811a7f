"""Hooks that mkdocs calls to build the site: pages made from the code, links to pages and code, formulas as MathML."""

from __future__ import annotations

import html
import re
from pathlib import Path
from textwrap import wrap
from typing import Any

from latex2mathml.converter import convert
from mkdocs.config.defaults import MkDocsConfig
from mkdocs.exceptions import PluginError
from mkdocs.structure.files import File, Files
from mkdocs.structure.pages import Page
from typer.cli import get_docs_for_click
from typer.main import get_command

ROOT = Path(__file__).parents[1]
API = "reference/api/"
FORMULA = re.compile(r'<(?P<tag>span|div) class="arithmatex">\\[(\[](?P<tex>.*?)\\[)\]]</(?P=tag)>', re.DOTALL)
FUNCTION = re.compile(r"(<mi>(?:cos|sin)</mi>)(?!<mo)")
"""A function whose argument is not in parentheses."""
REMOTE = re.compile(
    r"""<(?:script|img|iframe|source)[^>]*src=["']?(?:https?:)?//[^>]*>|<link[^>]*href=["']?https?://[^>]*>"""
)
CODE_LINK = re.compile(r"\]\((?:\.\./)+(slam/[\w/]+)(?:\.py)?\)")
ROOT_PAGES = {"README.md": "index.md", "CONTRIBUTING.md": "contributing.md", "CHANGELOG.md": "changelog.md"}
"""Pages of the site by the files of the repository's root that they show."""
ROOT_LINK = re.compile(rf"\]\(\.\./({'|'.join(map(re.escape, ROOT_PAGES))})")
FILE_LINK = re.compile(r"\[([\w/-]+\.md)\]\(((?:\.\./)*)([\w/-]+\.md)([^)]*)\)")
"""A link whose text is the name of its file."""
NAMED_PAGE = re.compile(r"docs/([\w-]+\.md)")
"""A page as help texts name it."""
PICTURE = re.compile(r'<img alt="[^"]*" src="([^"]+)" ?/?>')
INLINE_CODE = re.compile(r"(?<!</span>)(?<!<pre>)<code>[^<]+</code>")


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the pages that nobody writes."""
    pages = {
        **{page: root_page(file) for file, page in ROOT_PAGES.items()},
        "reference/scenario.md": scenario(),
        "reference/env.md": environment(),
        "reference/commands.md": commands(),
    }
    pages |= {f"{API}{name}.md": api(name) for name in api_packages(config)}
    for path, text in pages.items():
        files.append(File.generated(config, path, content=text))
    return files


def on_page_markdown(markdown: str, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Lead links out of docs/ to what the site shows of these files, and name pages by their titles.

    A module that the site does not show has no link.
    """
    packages = api_packages(config)
    up = "../" * page.url.count("/")
    titles = {path: title for section in config.nav or () for named in next(iter(section.values()))
              for title, path in named.items()}  # fmt: skip

    def linked(match: re.Match[str]) -> str:
        module = match[1].replace("/", ".")
        package = module.rpartition(".")[0]
        return f"]({up}{API}{package}.md#{module})" if package in packages else f"](# '{match[1]}.py')"

    markdown = ROOT_LINK.sub(lambda match: f"]({ROOT_PAGES[match[1]]}", markdown)
    markdown = FILE_LINK.sub(
        lambda match: f"[{titles.get(match[3], match[1])}]({match[2]}{match[3]}{match[4]})", markdown
    )
    return CODE_LINK.sub(linked, markdown)


def on_page_content(content: str, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Formulas as MathML, which browsers draw by themselves; a picture leads to itself, in its own size.

    Where a phone may end lines of code is marked.
    """

    def drawn(match: re.Match[str]) -> str:
        display = "block" if match["tag"] == "div" else "inline"
        formula = convert(html.unescape(match["tex"]).strip(), display=display)
        formula = FUNCTION.sub(r'\1<mspace width="0.167em" />', formula)
        return f'<div class="formula">{formula}</div>' if display == "block" else formula

    content = PICTURE.sub(r'<a href="\1">\g<0></a>', content)
    content = INLINE_CODE.sub(lambda match: breakable(match[0]), content)
    return FORMULA.sub(drawn, content)


def breakable(code: str) -> str:
    """Mark where a line of inline code may end, and the options in it."""
    code = re.sub(r"(?<=\w[./_=])(?=\w)", "<wbr>", code)
    return re.sub(r"(?<![\w-])--\w[\w-]*", r'<span class="option">\g<0></span>', code)


def on_post_build(config: MkDocsConfig) -> None:
    """Refuse a site whose pages load anything from a network."""
    for page in Path(config.site_dir).rglob("*.html"):
        if (asset := REMOTE.search(page.read_text())) is not None:
            raise PluginError(f"{page}: {asset[0]} loads from the network")


def root_page(file: str) -> str:
    """Read a file of the repository's root, with its links as the site has them."""
    text = (ROOT / file).read_text().replace("[docs/", "[").replace("](docs/", "](")
    for other, page in ROOT_PAGES.items():
        text = text.replace(f"]({other}", f"]({page}")
    return NAMED_PAGE.sub(r"[\1](\1)", text) if file == "CHANGELOG.md" else text


def scenario() -> str:
    """Every key, from the schema."""
    from slam.scenario.reference import scenario_reference

    return linked_pages(scenario_reference())


def environment() -> str:
    """The manual, from the class's docstring."""
    from slam.env.ids import find_env_id, manual

    return linked_pages(manual(find_env_id("Corridor-v0")))


def commands() -> str:
    """Every command with its options, as ``--help`` has them."""
    from slam.cli.main import app

    command = get_command(app)
    name_whole(command)
    context = command.make_context("hopslam", [], resilient_parsing=True)
    text = get_docs_for_click(obj=command, ctx=context, name="hopslam", title="Commands")
    text = re.sub(r"(`[^`]*`)|<", lambda match: match[1] or "&lt;", text).replace(
        "[bold]Examples[/bold]", "**Examples**:"
    )
    text = re.sub(
        r"^(hopslam .*(?:\n\S.*)*)$", lambda match: f"```sh\n{wrapped(match[1])}\n```", text, flags=re.MULTILINE
    )
    return linked_pages(text.replace("\n```\n\n```sh\n", "\n"))


def wrapped(example: str) -> str:
    """Continue a long command on further lines, so that a page need not scroll."""
    return " \\\n    ".join(wrap(example, 92, break_long_words=False, break_on_hyphens=False))


def name_whole(command: Any) -> None:
    """Let lists of commands say the first sentence of each command whole."""
    for part in getattr(command, "commands", {}).values():
        part.short_help = " ".join((part.short_help or part.help or "").partition("\n\n")[0].split())
        name_whole(part)


def linked_pages(text: str) -> str:
    """Make links of the pages that a text of the code names, for a page in reference/."""
    return NAMED_PAGE.sub(r"[\1](../\1)", text)


def api_packages(config: MkDocsConfig) -> list[str]:
    """The packages that the navigation has an API page of."""
    found: list[str] = re.findall(rf"{API}([\w.]+)\.md", str(config.nav))
    return found


def api(package: str) -> str:
    """Give each module of a package a heading, with what is public in it; of ``hopslam``, each name that it has."""
    if package == "hopslam":
        import hopslam

        blocks = [f"::: hopslam.{name}\n    options: {{show_attribute_values: false}}" for name in hopslam.__all__]
    else:
        paths = (ROOT / package.replace(".", "/")).glob("[!_]*.py")
        blocks = sorted(f"::: {package}.{path.stem}" for path in paths)
    return "\n\n".join([f"# {package}", *blocks])
