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
"""Page of the site for each file in the repository's root."""
ROOT_LINK = re.compile(rf"\]\(\.\./({'|'.join(map(re.escape, ROOT_PAGES))})")
FILE_LINK = re.compile(r"\[([\w/-]+\.md)\]\(((?:\.\./)*)([\w/-]+\.md)([^)]*)\)")
"""A link whose text is the name of its file."""
NAMED_PAGE = re.compile(r"docs/([\w-]+\.md)")
"""A page as help texts name it."""
PICTURE = re.compile(r'<img alt="[^"]*" src="([^"]+)" ?/?>')
INLINE_CODE = re.compile(r"(?<!</span>)(?<!<pre>)<code>[^<]+</code>")


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the generated pages."""
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
    """Redirect links to files outside docs/ to the pages made of them, and show page titles instead of file names.

    A link to a module without a page loses its target.
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
    """Turn formulas into MathML, which browsers render natively, and link every picture to its full-size file.

    Long inline code gets break points for narrow screens.
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
    """Insert break points into inline code, and mark the options in it."""
    code = re.sub(r"(?<=\w[./_=])(?=\w)", "<wbr>", code)
    return re.sub(r"(?<![\w-])--\w[\w-]*", r'<span class="option">\g<0></span>', code)


def on_post_build(config: MkDocsConfig) -> None:
    """Refuse a site whose pages load anything from a network."""
    for page in Path(config.site_dir).rglob("*.html"):
        if (asset := REMOTE.search(page.read_text())) is not None:
            raise PluginError(f"{page}: {asset[0]} loads from the network")


def root_page(file: str) -> str:
    """Read a file of the repository's root, and adapt its links to the site."""
    text = (ROOT / file).read_text().replace("[docs/", "[").replace("](docs/", "](")
    for other, page in ROOT_PAGES.items():
        text = text.replace(f"]({other}", f"]({page}")
    return NAMED_PAGE.sub(r"[\1](\1)", text) if file == "CHANGELOG.md" else text


def scenario() -> str:
    """Make the reference of all scenario keys from the schema."""
    from slam.scenario.reference import scenario_reference

    return linked_pages(scenario_reference())


def environment() -> str:
    """Make the manual of the environment from its class docstring."""
    from slam.env.ids import find_env_id, manual

    return linked_pages(manual(find_env_id("Corridor-v0")))


def commands() -> str:
    """Make the reference of all commands and options from their ``--help`` texts."""
    from slam.cli.main import app

    command = get_command(app)
    keep_first_sentences(command)
    context = command.make_context("hopslam", [], resilient_parsing=True)
    text = get_docs_for_click(obj=command, ctx=context, name="hopslam", title="Commands")
    text = re.sub(r"(`[^`]*`)|<", lambda match: match[1] or "&lt;", text)
    text = re.sub(r"\[bold\](Examples?)\[/bold\]", r"**\1**:", text)
    text = re.sub(
        r"^(hopslam .*(?:\n\S.*)*)$", lambda match: f"```sh\n{wrapped(match[1])}\n```", text, flags=re.MULTILINE
    )
    return linked_pages(text.replace("\n```\n\n```sh\n", "\n"))


def wrapped(example: str) -> str:
    """Continue a long command on further lines, so that a page need not scroll."""
    return " \\\n    ".join(wrap(example, 92, break_long_words=False, break_on_hyphens=False))


def keep_first_sentences(command: Any) -> None:
    """Use the whole first sentence of each command's help as its short help, which typer would truncate."""
    for part in getattr(command, "commands", {}).values():
        part.short_help = " ".join((part.short_help or part.help or "").partition("\n\n")[0].split())
        keep_first_sentences(part)


def linked_pages(text: str) -> str:
    """Turn page names in a help text or docstring into links, for a page in reference/."""
    return NAMED_PAGE.sub(r"[\1](../\1)", text)


def api_packages(config: MkDocsConfig) -> list[str]:
    """List the packages that have an API page in the navigation."""
    found: list[str] = re.findall(rf"{API}([\w.]+)\.md", str(config.nav))
    return found


def api(package: str) -> str:
    """Make the API page of a package: a section for each module, or for each public name of ``hopslam``."""
    if package == "hopslam":
        import hopslam

        blocks = [f"::: hopslam.{name}\n    options: {{show_attribute_values: false}}" for name in hopslam.__all__]
    else:
        paths = (ROOT / package.replace(".", "/")).glob("[!_]*.py")
        blocks = sorted(f"::: {package}.{path.stem}" for path in paths)
    return "\n\n".join([f"# {package}", *blocks])
