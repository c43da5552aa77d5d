"""Settings of the documentation site; `docs/tools/sources.py` writes the folder that Sphinx reads."""

import os
import re
import sys
from functools import partial
from pathlib import Path

from jupyter_cache.executors import utils as execution

import grind_env

sys.path.insert(0, str(Path(__file__).parent / "tools"))

os.environ["PATH"] = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"  # pages run `grind`
os.environ |= {"COLUMNS": "92", "TTY_COMPATIBLE": "0"}  # for their output; kernels pretend to be terminals

project = "grind_env"
copyright = "2026, the grind_env authors"
author = "the authors of grind_env"
release = version = grind_env.__version__

extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.doctest",
    "sphinx.ext.napoleon",
    "sphinx_copybutton",
    "docstrings",
    "formulas",
    "lean",
    "places",
    "shell_cells",
]
templates_path = ["templates"]
nitpicky = True
DOCUMENTED = re.findall(
    r"automodule:: (\S+)", "".join(path.read_text() for path in Path(__file__).parent.glob("*/*.md"))
)
nitpick_ignore_regex = [
    # other libraries: links to them would need the network
    ("py:.*", r"(abc|collections|decimal|enum|os|pathlib|types|typing)\..*"),
    ("py:.*", r"(numpy|np|gymnasium|numba|stable_baselines3|torch)\..*"),
    ("py:.*", r"(Axes|Console|Figure|Graph|Markup|Window|.*\.(EpisodesT|Make|SimulationT|What))"),
    # names of modules without a page are internal
    ("py:.*", rf"grind_env\.(?!({'|'.join(re.escape(name[10:]) for name in DOCUMENTED)})\.\w+$).*"),
]

html_theme = "furo"
html_title = f"grind_env {release}"
html_static_path = ["static"]
html_css_files = ["site.css"]
html_sidebars = {
    "**": [
        "sidebar/brand.html",
        "project.html",
        "sidebar/search.html",
        "sidebar/scroll-start.html",
        "sidebar/navigation.html",
        "sidebar/scroll-end.html",
    ]
}
html_copy_source = False
html_use_index = False  # see docs/tools/lean.py
html_search_scorer = str(Path(__file__).parent / "tools" / "scorer.js")

add_module_names = False
smartquotes = False  # a copied --set '#101=15000' must stay as it is
default_role = "code"  # single backticks are code in this package
autodoc_member_order = "bysource"
autodoc_default_options = {"members": True, "show-inheritance": True}
autodoc_preserve_defaults = True
napoleon_numpy_docstring = False
napoleon_use_ivar = True
python_use_unqualified_type_names = True

myst_enable_extensions = ["colon_fence", "dollarmath"]
myst_dmath_allow_space = myst_dmath_allow_digits = False  # a $ next to a space or number is money
myst_heading_anchors = 4
copybutton_prompt_text = r">>> |\.\.\. |\$ "
copybutton_prompt_is_regexp = True

# Notebooks have their outputs in git; how-to pages are executed here, so that no output is copied by hand.
nb_ipywidgets_js = {}
nb_execution_mode = "force"
nb_execution_excludepatterns = ["tutorials/*.ipynb"]
nb_execution_in_temp = True
nb_execution_raise_on_error = True
nb_execution_timeout = 1800
# show the output of a command as one block; `nb_merge_streams` would break lines between its pieces
execution.executenb = partial(execution.executenb, coalesce_streams=True)
