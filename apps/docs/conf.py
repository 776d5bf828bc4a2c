"""The site's pages: README and docs/, by Sphinx (apps/docs/build.sh)."""

import re

project = "Holdfast"
extensions = ["myst_parser", "sphinx.ext.mathjax"]
root_doc = "index"
include_patterns = ["index.md", "docs/**"]
myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 3
html_theme = "furo"
html_title = "Holdfast"
html_show_copyright = False
html_show_sphinx = False
html_copy_source = False


def fence_equations(app, page, source):
    """Equations as they are: Sphinx would put those of several lines into an environment that takes no \\tag."""
    directive = "```{math}\n:no-wrap:\n\n\\begin{equation*}\n%s\\end{equation*}\n```"
    source[0] = re.sub(r"^```math\n(.*?)^```$", lambda found: directive % found[1], source[0], flags=re.DOTALL | re.MULTILINE)


def setup(app):
    app.connect("source-read", fence_equations)
