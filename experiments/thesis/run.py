"""Chapters 2 to 4 of the thesis: every number, figure and table again, what was printed beside it.

`python -m experiments.thesis.run [FOLDER]` prints the tables and draws the figures into `build/thesis` by default.
"""

from experiments.thesis import chapter2, chapter3, chapter4
from experiments.thesis.table import folder_of

if __name__ == "__main__":
    for chapter in (chapter2, chapter3, chapter4):
        chapter.main(folder_of())
