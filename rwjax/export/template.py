"""Text files from templates of this folder."""

from typing import Any

import jinja2


def rendered(template: str, **values: Any) -> str:
    """A template's text with its values; a value that is missing is an error.

    Args:
        template: Name of the template.
        values: What it shows, by name.

    Returns:
        The text.
    """
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("rwjax", "export"),
        autoescape=False,  # C and Python, no HTML
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
        undefined=jinja2.StrictUndefined,
    )
    return environment.get_template(template).render(**values)
