"""Counts of the documentation's prose: length of sentences, cells of tables too wide to read."""

import re

WIDEST_CELL = 200  # characters of a cell in a table


def sentences(page: str) -> list[str]:
    """Sentences of a Markdown page: of paragraphs and list items, without code, tables and headings."""
    page = re.sub(r"^(```|~~~).*?^\1", "\n", page, flags=re.M | re.S)
    page = re.sub(r"^\s*(#|\|).*$", "\n", page, flags=re.M)
    page = re.sub(r"^\s*([-*+]|\d+\.)\s+", "\n\n", page, flags=re.M)
    page = re.sub(r"!?\[([^\]]*)\]\([^)]*\)", r"\1", page)
    blocks = (" ".join(block.split()) for block in re.split(r"\n\s*\n", page))
    ends = re.compile(r"(?<=[.!?])[\"')*]*\s+(?=[\"'(*`$]*[A-ZÀ-ÞΑ-Ω\d`$])")
    return [one for block in blocks if block for one in ends.split(block) if re.search(r"[^\W\d]{2}", one)]


def wide_cells(page: str) -> int:
    """Cells of a page's tables that are wider than `WIDEST_CELL` characters."""
    rows = (line for line in page.splitlines() if line.lstrip().startswith("|"))
    return sum(len(cell.strip()) > WIDEST_CELL for row in rows for cell in re.split(r"(?<!\\)\|", row))
