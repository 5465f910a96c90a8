"""Files of measurements read, of whatever format: text, gz, Parquet, MAT and NPZ, told apart by how they begin."""

import gzip
import io
import os
import zipfile
import zlib
from pathlib import Path

import numpy as np

from rwjax.errors import LogError
from rwjax.logs.array_sheet import array_sheet
from rwjax.logs.sheet import Sheet
from rwjax.logs.text_sheet import SEPARATORS, text_sheet
from rwjax.text_files import cannot_be_read

MOST_BYTES = 2_000_000_000
"""Size of a file, unpacked, above which it is no log of one run."""

WORKBOOKS = (".xlsx", ".xlsm", ".ods")
"""How the names of spreadsheets' own files end."""


def read_sheet(path: str | os.PathLike[str]) -> Sheet:
    """The table that a file holds.

    Args:
        path: The file.

    Returns:
        Its columns, whose meaning is up to the rig file.

    Raises:
        LogError: Where the file cannot be read, is of a format that is not read, or holds no table.
    """
    try:
        content = Path(path).read_bytes()
    except IsADirectoryError:
        raise LogError(f"{path}: is a folder; name its files, such as `{Path(path) / '*.csv'}`") from None
    except OSError as bad:
        raise LogError(cannot_be_read(path, bad)) from None
    return _sheet(path, _unpacked(path, content))


def _unpacked(path: str | os.PathLike[str], content: bytes) -> bytes:
    """The bytes of a file, without gz around them."""
    if not content.startswith(b"\x1f\x8b"):
        return content
    try:
        with gzip.open(io.BytesIO(content)) as file:
            plain = file.read(MOST_BYTES + 1)
    except (OSError, EOFError, zlib.error):
        raise LogError(f"{path}: the gz file is cut off or damaged; pack it again") from None
    if len(plain) > MOST_BYTES:
        raise LogError(f"{path}: more than {MOST_BYTES:g} bytes unpacked; split it into runs")
    return plain


def _sheet(path: str | os.PathLike[str], content: bytes) -> Sheet:
    """The table in a file's bytes, by how they begin."""
    if content.startswith(b"PAR1"):
        return _parquet(path, content)
    if content.startswith(b"PK\x03\x04"):
        return _npz(path, content)
    if content.startswith(b"\x89HDF") or content.startswith(b"MATLAB 7.3"):
        raise LogError(f'{path}: is HDF5, as MATLAB\'s -v7.3; save it there with save("run.mat", "-v7")')
    if content.startswith(b"MATLAB") or (Path(path).suffix.lower() == ".mat" and b"\0" in content[:128]):
        return _mat(path, content)
    if content.startswith(b"\xd0\xcf\x11\xe0"):
        raise LogError(f"{path}: is an old Excel workbook; save its sheet as CSV")
    return text_sheet(path, _text(path, content))


def _parquet(path: str | os.PathLike[str], content: bytes) -> Sheet:
    import polars as pl

    try:
        table = pl.read_parquet(io.BytesIO(content))
    except BaseException as error:  # of a damaged file polars may panic, which is no Exception
        if not isinstance(error, Exception | pl.exceptions.PanicException):
            raise
        raise LogError(f"{path}: the Parquet file is cut off or damaged; write it again") from None
    return array_sheet(path, {name: table[name].to_numpy() for name in table.columns})


def _npz(path: str | os.PathLike[str], content: bytes) -> Sheet:
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            names = archive.namelist()
        plain = bool(names) and all(name.endswith(".npy") for name in names)
        with np.load(io.BytesIO(content), allow_pickle=False) as held:
            arrays = {name: held[name] for name in held.files} if plain else {}
    # reason: what a damaged archive makes zipfile, zlib and NumPy raise; NotImplementedError is zipfile's for an unknown packing
    except (ValueError, OSError, EOFError, KeyError, zipfile.BadZipFile, zlib.error, NotImplementedError):
        if Path(path).suffix.lower() in WORKBOOKS:
            raise LogError(f"{path}: is a damaged workbook; save its sheet as CSV") from None
        raise LogError(f"{path}: the NPZ file is damaged or holds objects; write it again from plain arrays") from None
    if not plain:
        workbook = "xl/workbook.xml" in names
        raise LogError(
            f"{path}: is an " + ("Excel workbook; save its sheet as CSV" if workbook else "archive of files; unpack it")
        )
    return array_sheet(path, arrays)


def _mat(path: str | os.PathLike[str], content: bytes) -> Sheet:
    from scipy.io import loadmat  # a fifth of a second

    try:
        held = loadmat(io.BytesIO(content), simplify_cells=True)
    except Exception:  # scipy's parser raises what its steps raise, of a dozen kinds
        raise LogError(
            f'{path}: the MAT file is damaged or of a kind that is not read; save it with save("run.mat", "-v7")'
        ) from None
    return array_sheet(path, {name: value for name, value in held.items() if not name.startswith("__")})


def _text(path: str | os.PathLike[str], content: bytes) -> str:
    r"""A file's bytes as text, every line ended by `\n`: UTF-8, UTF-16 or, where they are neither, Windows' Latin alphabet."""
    wide = content.startswith((b"\xff\xfe", b"\xfe\xff"))
    try:
        text = content.decode("utf-16" if wide else "utf-8-sig")
    except UnicodeDecodeError as bad:
        if wide:
            raise LogError(f"{path}: begins as UTF-16 and is none; save it as UTF-8") from None
        text = bad.object.decode("cp1252", "replace")
    text = text.replace("\r\n", "\n").replace("\r", "\n")
    before, nul, _ = text.partition("\0")
    if nul and not _has_header(before):
        raise LogError(f"{path}: is no text; a log is CSV, Parquet, MAT or NPZ, plain or as gz")
    if nul:
        line = before.count("\n") + 1
        raise LogError(f"{path}:{line}: holds NUL bytes, as a loss of power leaves them; delete this line as a whole")
    return text


def _has_header(text: str) -> bool:
    """Whether the first whole line that is neither a note nor empty may name columns: printed characters, with separators."""
    lines = (line for line in text.split("\n")[:-1] if line.strip() and not line.startswith("#"))
    first = next(lines, "")
    return first.replace("\t", " ").isprintable() and any(sign in first for sign in SEPARATORS)
