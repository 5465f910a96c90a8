"""The pages of this folder as a site, by Sphinx: `make docs` writes build/docs. It executes the notebooks; a warning ends the build."""

from pathlib import Path

project = "rwjax"
copyright = "the rwjax authors"
extensions = ["myst_nb", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx_copybutton"]
html_theme = "furo"
html_title = "rwjax"
myst_heading_anchors = 4  # links between pages name headings as GitHub does
# links to files of the repository, which tests/test_docs.py follows; `csv`, which is no language to Pygments; the language of notebooks,
# which only their kernel tells, where `make pages` does not execute them
suppress_warnings = ["myst.xref_missing", "misc.highlighting_failure", "myst-nb.lexer"]
nb_execution_mode = "force"
nb_execution_timeout = 300
nb_execution_raise_on_error = True
nb_execution_show_tb = True
autodoc_typehints = "none"  # the signature has them, with shapes
copybutton_prompt_text = r"\$ "
copybutton_prompt_is_regexp = True
if not (Path(__file__).parent / "_generated").is_dir():
    suppress_warnings.append("toc.not_readable")  # `make pages` leaves the gallery out
