"""What a user does in the place of an effect is said of every effect that a MuJoCo model does not hold."""

from rwjax.effects.library import BY_NAME, of_kind
from rwjax.export.instead import instead
from rwjax.kinds import ONE_AXIS


def test_every_effect_has_something_that_is_done_instead() -> None:
    names = {name for kind in ONE_AXIS for name in of_kind(kind)}
    assert len(names) > 30 and not [name for name in names if not instead(BY_NAME[name])]


def test_where_an_effect_acts_says_what_is_done() -> None:
    assert instead(BY_NAME["drive.deadzone"]) == "apply it to the command before the actuator"
    assert instead(BY_NAME["sensor.delay"]) == instead(BY_NAME["sensor.offset"]) == "apply it to what the sensors give"
