"""What the notes of a log file say to rwjax: the role of the run, and what was added to the rig for it."""

import math

from rwjax.errors import LogError, RigError, nearest
from rwjax.logs.sheet import ROLES, Sheet, is_number
from rwjax.rig.effect_section import rig_value
from rwjax.rig.model import Rig

PADDING = ",;\t "
"""What a spreadsheet puts behind a note, whose row it makes as long as the others."""


def is_validation(sheet: Sheet) -> bool:
    """Whether a log is kept out of every fit and every choice, by its note `# role: validate`.

    Args:
        sheet: The log file as text.

    Returns:
        False without the note.

    Raises:
        LogError: For a role that is neither `train` nor `validate`.
    """
    role = sheet.notes.get("role", "train").rstrip(PADDING)
    if role.lower() not in ROLES:
        raise LogError(f"{sheet.where_noted('role')}: `# role: {role}` is unknown; it is `train` or `validate`")
    return role.lower() == "validate"


def added(sheet: Sheet, rig: Rig) -> dict[str, float]:
    """Known differences of the rig's numbers in one run, from notes such as `# add axis.inertia: 0.012`.

    Args:
        sheet: The log file as text.
        rig: The rig, whose numbers the notes name.

    Returns:
        Differences [SI] by the number's name. Notes that begin with `add` and name no number are passed over.

    Raises:
        LogError: For a number that the rig does not hold, and for a difference that cannot be.
    """
    found = {}
    held = {name.lower(): name for name in rig.values}  # keys of notes are read in small letters
    last = {name.rpartition(".")[2] for name in held}
    for key, note in sheet.notes.items():
        value = note.rstrip(PADDING)
        word, _, name = (part.strip() for part in key.partition(" "))
        if word != "add" or " " in name or not ("." in name or name in last):  # any other note
            continue
        if name not in held:
            near = nearest(name, rig.values)
            raise LogError(
                f"{sheet.where_noted(key)}: `# {key}: {value}`: the rig file has no `{name}`; the nearest is `{near}`"
            )
        if not is_number(value) or not math.isfinite(float(value)):
            raise LogError(
                f"{sheet.where_noted(key)}: `# {key}: {value}` has to be one number, such as `# {key}: 0.012`"
            )
        name = held[name]
        if name in rig.tied:
            raise LogError(
                f"{sheet.where_noted(key)}: `# {key}: {value}`: `{name}` is {rig.tied[name]} by `fit.tied`; add to what it follows from"
            )
        total = rig.values[name] + float(value)
        makes = f"{sheet.where_noted(key)}: `# {key}: {value}` makes `{name}` {total:.6g} from {rig.values[name]:.6g}"
        if name.endswith(".inductance") and rig.values[name] == 0.0:
            raise LogError(f"{makes}; give the rig file an inductance above 0")
        try:
            rig_value(name, total)
        except RigError as error:
            raise LogError(f"{makes}; {str(error).partition('; ')[2]}") from None
        found[name] = float(value)
    return found


def ignored(sheet: Sheet) -> list[str]:
    """The columns that a note such as `# ignore: temperature_C, state` leaves out.

    Args:
        sheet: The log file as text.

    Returns:
        Names of columns of the log.

    Raises:
        LogError: For a name that is no column.
    """
    names = [name.strip() for name in sheet.notes.get("ignore", "").replace(";", ",").split(",") if name.strip()]
    held = {*sheet.names}
    if absent := next((name for name in names if name not in held), None):
        near = nearest(absent, [*sheet.names])
        raise LogError(f"{sheet.where_noted('ignore')}: `# ignore: {absent}`: no such column; the nearest is `{near}`")
    return names
