"""Sphinx reads README.md and docs/ as they are; scripts/site adds gallery, notebook and references."""
import itertools
import os
import re

project = "cmpg-vk"
html_title = "cmpg-vk"
extensions = ["myst_parser"] + (["sphinx.ext.autodoc"] if os.environ.get("CMPG_SITE_MODULE") else [])
source_suffix = {".md": "markdown", ".rst": "restructuredtext"}
root_doc = "index"
exclude_patterns = ["docs/site"]
myst_heading_anchors = 4
myst_enable_extensions = ["colon_fence"]
html_theme = "furo"
html_show_copyright = False
html_show_sourcelink = False
html_copy_source = False
autodoc_member_order = "bysource"
autodoc_typehints = "signature"
highlight_language = "text"
suppress_warnings = ["myst.header"]  # a page may begin below the first level


def plain_docstring(app, what, name, thing, options, lines):
    """Docstrings are plain text: what is indented stays as it is, the rest are paragraphs."""
    result = []
    for indented, group in itertools.groupby(lines, lambda line: line.startswith(" ")):
        if indented:
            result += ["", "::", "", *("    " + line for line in group), ""]
        else:
            result += [re.sub(r"([\\*`|_])", r"\\\1", line) for line in group]
    lines[:] = result


def setup(app):
    if "sphinx.ext.autodoc" in extensions:  # which alone has the event
        app.connect("autodoc-process-docstring", plain_docstring)
