"""Settings of Sphinx for this site; `make docs` builds it."""

import os
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))  # for site_extension

from site_extension import code_link

import khepera_forage

project = "khepera_forage"
author = "the khepera_forage contributors"
release = version = khepera_forage.__version__
extensions = [
    "myst_nb",
    "sphinx.ext.apidoc",
    "sphinx.ext.autodoc",
    "sphinx.ext.linkcode",
    "sphinx.ext.napoleon",
    "site_extension",
]
exclude_patterns = ["api/modules.rst"]
os.environ["SPHINX_APIDOC_OPTIONS"] = "members,show-inheritance,ignore-module-all"  # read by sphinx.ext.apidoc
apidoc_modules = [
    {
        "path": "../khepera_forage",
        "destination": "api",
        # The commands have a page of their own; nobody calls the compiler.
        "exclude_patterns": [f"../khepera_forage/{name}" for name in ("cli", "__main__.py", "compilation.py")],
    }
]
apidoc_module_first = True

html_theme = "furo"
html_title = "khepera_forage"
html_static_path = ["static"]
html_css_files = ["site.css"]
html_favicon = "static/favicon.svg"
html_show_sourcelink = False
html_copy_source = False
html_show_copyright = False

# Headings down to the fourth level can be linked to, as in the repository.
myst_heading_anchors = 4
nb_execution_mode = "force"
nb_execution_timeout = 300  # seconds a cell, on a busy machine
nb_execution_raise_on_error = True
nb_execution_show_tb = True
nb_merge_streams = True

default_role = "code"
highlight_language = "text"
add_module_names = False
autodoc_member_order = "bysource"
autodoc_preserve_defaults = True
autodoc_typehints_format = "short"
autodoc_mock_imports = ["stable_baselines3"]  # 2 GB, for one base class
napoleon_google_docstring = True
napoleon_numpy_docstring = False
napoleon_custom_sections = [("Attributes", "params_style")]  # without types, which the signature of the class has
napoleon_attr_annotations = False
python_maximum_signature_line_length = 100
toc_object_entries_show_parents = "hide"
linkcode_resolve = code_link

nitpicky = True
nitpick_ignore_regex = [
    # Names of other packages have no page here: a build needs no network, so that it cannot look theirs up.
    ("py:.*", r"(?!khepera_forage).*"),
    # Type variables have no documentation.
    ("py:.*", r"khepera_forage\..*\.(_\w+|T|RowT|ActionT)"),
]
