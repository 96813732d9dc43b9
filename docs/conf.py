"""Settings of the documentation, which `make docs` builds with Sphinx and MyST.

The source is the whole repository, so that links between README.md, docs/ and results/ are the
same here and where the files are read as they are.
"""

import re
from importlib.metadata import version as version_of
from typing import Any

import latex2mathml.converter
from docutils.nodes import SkipNode

project = "lodbench"
author = "the lodbench authors"
release = version_of("lodbench")

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.viewcode",
    "sphinx_click",
    "sphinx_copybutton",
    "sphinx_design",
]
root_doc = "docs/index"
include_patterns = [
    "docs/*.md",
    "README.md",
    "CHANGELOG.md",
    "results/*.md",
    "results/gallery/*.md",
]

myst_enable_extensions = ["colon_fence", "dollarmath"]
myst_heading_anchors = 3

autodoc_typehints = "description"
autodoc_typehints_description_target = "documented"
autodoc_member_order = "bysource"
autodoc_preserve_defaults = True

html_theme = "furo"
html_static_path = ["static"]
html_css_files = ["page.css"]
html_theme_options = {
    "light_css_variables": {
        "sidebar-caption-font-size": "0.8125rem",
        "toc-title-font-size": "0.8125rem",
    }
}
html_math_renderer = "mathml"
html_title = f"lodbench {release}"
html_copy_source = False

_FOR_KEYBOARDS_AND_READERS = """
document.addEventListener("DOMContentLoaded", () => {
  const set = (which, name, value) =>
    document.querySelectorAll(which).forEach((each) => each.setAttribute(name, value));
  const wide = {
    pre: "Code", ".table-wrapper": "Table", ".math-wrapper": "Formula", "p:has(> img)": "Picture",
  };
  const scroll = () => Object.entries(wide).forEach(([which, name]) =>
    document.querySelectorAll(which).forEach((each) => {
      const scrolls = each.scrollWidth > each.clientWidth;
      const said = { tabindex: "0", role: "group", "aria-label": `${name}, scrolls sideways` };
      Object.entries(said).forEach(([key, value]) =>
        scrolls ? each.setAttribute(key, value) : each.removeAttribute(key));
    }));
  addEventListener("resize", scroll);
  scroll();
  set(".caption[role=heading]", "aria-level", "2");
  set(".sidebar-drawer", "aria-label", "Pages");
  set(".toc-drawer", "aria-label", "On this page");
});
"""
"""What the theme leaves out: what scrolls takes the keyboard, and drawers have names."""

_NAMED = re.compile(r"([A-Za-z_][\w, ]*?) {2,}(\S.*)")


def lay_out_names(
    app: Any, what: str, name: str, obj: object, options: object, lines: list[str]
) -> None:
    """Turn the lines ``name  what it is`` of our docstrings into definition lists, in place."""
    laid: list[str] = []
    within = False
    for line in lines:
        if found := _NAMED.fullmatch(line):
            laid += ["", found[1], f"    {found[2]}"]
            within = True
        elif within and line.startswith(" "):
            laid.append(f"    {line.strip()}")
        else:
            laid += ["", line] if within and line else [line]
            within = False
    lines[:] = [*laid, ""]


def write_formula(translator: Any, node: Any) -> None:
    """Write a formula as MathML, which browsers typeset by themselves."""
    display = "block" if node.tagname == "math_block" else "inline"
    formula = latex2mathml.converter.convert(node.astext(), display=display)
    within = '<div class="math-wrapper">{}</div>' if display == "block" else "{}"
    translator.body.append(within.format(formula))
    raise SkipNode


def setup(app: Any) -> None:
    """Connect what this file adds to Sphinx."""
    app.add_html_math_renderer("mathml", (write_formula, None), (write_formula, None))
    app.add_js_file(None, body=_FOR_KEYBOARDS_AND_READERS)
    app.connect("autodoc-process-docstring", lay_out_names)
