# SPDX-License-Identifier: Apache-2.0
"""Sphinx: reference pages of the module, from its docstrings; see tools/cmake/Reference.cmake."""
import malha

project = "malha"
version = release = malha.__version__
extensions = ["sphinx.ext.autodoc"]
html_theme = "alabaster"
html_theme_options = {"description": "Deformable bodies in Python", "page_width": "1200px", "sidebar_width": "320px",
                      "fixed_sidebar": True}
html_copy_source = html_show_copyright = html_show_sphinx = False
html_sidebars = {"**": ["about.html", "localtoc.html", "searchbox.html"]}
autodoc_member_order = "bysource"
autodoc_docstring_signature = True
autoclass_content = "both"  # what __init__ says, too
