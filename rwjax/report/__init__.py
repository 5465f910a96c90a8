"""What a person looks at: sentences, figures, tables, the HTML page."""

import logging

# Where there is no place for the fonts that matplotlib remembers, it takes a temporary folder, and warns on every run.
logging.getLogger("matplotlib").setLevel(logging.ERROR)
