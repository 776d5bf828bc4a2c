"""The site's pages: README and docs/, by Sphinx (apps/docs/build.sh)."""

project = "Holdfast"
extensions = ["myst_parser", "sphinx.ext.mathjax"]
root_doc = "index"
include_patterns = ["index.md", "docs/**"]
myst_enable_extensions = ["dollarmath"]
myst_fence_as_directive = ["math"]
myst_heading_anchors = 3
myst_dmath_double_inline = True
html_theme = "furo"
html_title = "Holdfast"
html_show_copyright = False
html_show_sphinx = False
html_copy_source = False
