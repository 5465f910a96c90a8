"""The command `import`: logs in rwjax's layout from files of any."""

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, NamedTuple

import typer

from rwjax.cli.options import finite, keep_input, positive, results
from rwjax.cli.terminal import listed, next_command, say
from rwjax.errors import InputError, LogError

Files = Annotated[
    list[Path],
    typer.Argument(metavar="FILE…", help="files of measurements: text, gz, Parquet, MAT, NPZ", show_default=False),
]
Rig = Annotated[
    Path | None, typer.Option("--rig", metavar="RIG", help="rig file (TOML) whose [columns] says what they hold")
]
Supply = Annotated[float | None, typer.Option(help="voltage of a PWM at full power [V], in a section that is proposed")]
Output = Annotated[Path | None, typer.Option("-o", metavar="DIR", help="folder for the logs")]


class Proposed(NamedTuple):
    """What a file holds, and what is proposed for it.

    Attributes:
        held: Its columns, a line each.
        kind: Kind of the rig file.
        section: Lines of the section `[columns]`.
        taken: Whether `rwjax init` takes the file.
    """

    held: str
    kind: str
    section: str
    taken: bool


def import_logs(files: Files, rig_file: Rig = None, output: Output = None, supply: Supply = None) -> None:
    """Write logs in rwjax's own layout from files of any, by [columns] of the rig file. Without it, says which columns there are, and proposes a section.

    Example: `rwjax import recording.mat --rig rig.toml -o logs`
    """
    from rwjax.rig.read import read_rig

    rig = read_rig(rig_file) if rig_file is not None else None
    if output is not None and rig is None:
        raise InputError(f"-o {output}: logs are written by a rig file; give it with --rig")
    if supply is not None:
        finite(supply=supply)
        positive(supply=supply)
    if rig is None or (output is None and not (rig.sources or rig.columns)):
        found = {path: _proposed(path, rig.kind if rig is not None else None, supply) for path in files}
        ahead = [] if rig is not None else _ahead(found, supply)
        say("\n\n".join([*(one.held for one in found.values()), *_sections(found), *ahead]))
        return
    if supply is not None:
        raise InputError(
            "--supply is of a section that is proposed, and here the rig file says what the columns are: write it there"
        )
    from rwjax.logs.convert import converted
    from rwjax.logs.write import log_text
    from rwjax.text_files import write_text

    if output is None:
        raise InputError("no folder for the logs; give one with -o")
    targets = {path: output / f"{_stem(path)}.csv" for path in files}
    if len({*targets.values()}) < len(files):
        raise InputError(
            f"{output}: two of the files would have the same name there; import them into folders of their own"
        )
    for target in targets.values():
        keep_input(target, *files)
    logs = {target: converted(path, rig) for path, target in targets.items()}
    texts = {target: log_text(columns, notes, target) for target, (columns, notes) in logs.items()}
    for target, text in texts.items():
        _keep_others(target, text)
    with results(output):
        for target, text in texts.items():
            write_text(target, text, LogError)
    say("\n".join(f"{path}: {', '.join(logs[target][0])}; written to {target}" for path, target in targets.items()))


def _keep_others(target: Path, text: str) -> None:
    """Raises `InputError` where a log's place is taken by anything but the same log."""
    from rwjax.text_files import read_text

    if target.exists() and (target.is_dir() or read_text(target, LogError) != text):
        raise InputError(
            f"{target}: is there already and is not what would be written: it may have been edited, or imported with other "
            "[columns]; give another folder with -o, or move it"
        )


def _stem(path: Path) -> str:
    """A file's name without its ends."""
    return path.name.removesuffix(".gz").rpartition(".")[0] or path.name


def _proposed(path: Path, kind: str | None, supply: float | None) -> Proposed:
    """What a file holds, and a section for it; without a kind of rig for the one that `init` takes."""
    from rwjax.errors import printable_lines
    from rwjax.logs.propose import description, proposal
    from rwjax.logs.read_sheet import read_sheet
    from rwjax.methods.first_rig import Datasheet, check_columns, kind_of

    sheet = read_sheet(path)
    kind = kind or kind_of(sheet, Datasheet())
    held = "\n".join([f"{path}: {len(sheet.names)} columns", *description(sheet)])
    try:
        check_columns(sheet, kind)
        taken = True
    except LogError:
        taken = False
    return Proposed(printable_lines(held), kind, printable_lines(proposal(sheet, kind, supply=supply)), taken)


def _alike(found: Mapping[Path, Proposed]) -> list[list[Path]]:
    """The files by what is proposed for them, those alike together."""
    alike: dict[tuple[str, str], list[Path]] = {}
    for path, one in found.items():
        alike.setdefault((one.kind, one.section), []).append(path)
    return [*alike.values()]


def _sections(found: Mapping[Path, Proposed]) -> list[str]:
    """Each section that is proposed, once, with the files that it is for where there are several."""
    return [
        f"for a `{found[paths[0]].kind}` rig file{f' of {listed([*map(str, paths)])}' if len(found) > 1 else ''}:\n\n"
        f"{found[paths[0]].section}"
        for paths in _alike(found)
    ]


def _ahead(found: Mapping[Path, Proposed], supply: float | None) -> list[str]:
    """The command that writes a first rig file, for the first files that are alike and that it takes."""
    usable = [paths for paths in _alike(found) if found[paths[0]].taken]
    volts = [] if supply is None else ["--supply", f"{supply:g}"]
    return [next_command("init", *usable[0], *volts, "-o", "rig.toml")] if usable else []
