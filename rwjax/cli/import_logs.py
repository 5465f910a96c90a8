"""The command `import`: logs in rwjax's layout from files of any."""

from pathlib import Path
from typing import Annotated

import typer

from rwjax.cli.options import finite, keep_input, positive, results
from rwjax.cli.terminal import say
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
        say("\n\n".join(_proposed(path, rig.kind if rig is not None else None, supply) for path in files))
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


def _proposed(path: Path, kind: str | None, supply: float | None) -> str:
    """What a file holds, and a section for it; without a kind of rig for the one that `init` takes."""
    from rwjax.errors import printable_lines
    from rwjax.logs.propose import description, proposal
    from rwjax.logs.read_sheet import read_sheet
    from rwjax.methods.first_rig import Datasheet, kind_of

    sheet = read_sheet(path)
    kind = kind or kind_of(sheet, Datasheet())
    head = f"{path}: {len(sheet.names)} columns"
    return printable_lines(
        "\n".join([head, *description(sheet), f"for a `{kind}` rig file:", "", proposal(sheet, kind, supply=supply)])
    )
