"""Remarks: what the logs cannot tell."""

from dataclasses import replace

import numpy as np

from rwjax.diagnosis.hypothesis import Hypothesis
from rwjax.diagnosis.remarks import remarks
from rwjax.diagnosis.search.successive_halving import SuccessiveHalving
from rwjax.diagnosis.settings import RemarkSettings
from rwjax.fitting.uncertainty import uncertainty
from rwjax.rig.model import Rig
from tests.diagnosis.simulated import TIME, fits_of, moved_to, true_log
from tests.systems import platform, record, run

ONE_RUN = "one run was fitted: nothing says how well runs repeat, so the floor is a lower bound"


def test_a_single_run_is_remarked_on() -> None:
    rig, log = platform(), true_log(platform())
    base = fits_of(rig, log)(Hypothesis())
    said = remarks(rig, [log], [0], base, [base], uncertainty(base), (), RemarkSettings())
    assert said[-1] == ONE_RUN
    assert ONE_RUN not in remarks(rig, [log, log], [0, 1], base, [base], uncertainty(base), (), RemarkSettings())


def test_a_command_that_never_changes_is_remarked_on() -> None:
    rig, log = platform(), true_log(platform())
    base, still = fits_of(rig, log)(Hypothesis()), replace(log, command=np.full_like(log.command, 5.0))
    for logs, expected in (([still, still], True), ([still, log], False)):
        said = remarks(rig, logs, [0, 1], base, [base], uncertainty(base), (), RemarkSettings())
        assert any(one.startswith("the command changes in no run that was fitted") for one in said) == expected


def test_numbers_that_diverged_and_values_of_each_run_are_remarked_on() -> None:
    rig, log = platform(), true_log(platform())
    base = fits_of(rig, log)(Hypothesis())
    own = replace(rig, per_run=("axis.inertia",))
    said = remarks(own, [log], [0], base, [base], uncertainty(base), ("axis.inertia",), RemarkSettings())
    assert any(one.startswith("axis.inertia: more than 10000 times what the rig file says") for one in said)
    assert any(one.startswith("axis.inertia: one value for all runs") for one in said)


def test_numbers_far_from_the_files_beside_a_name_are_remarked_on_and_others_are_not() -> None:
    rig, named = (
        platform("viscous = 0.02", free='"axis.inertia", "axis.friction.viscous"'),
        Hypothesis(("axis.coulomb",)),
    )
    log = true_log(rig, **{"axis.coulomb": {"M_c": 0.03}})
    fits = fits_of(rig, log)
    base = fits(Hypothesis())
    SuccessiveHalving(fits).fit([named], Hypothesis())

    def said(inertia: float, viscous: float, rig: Rig = rig) -> list[str]:
        values = {"axis.inertia": rig.values["axis.inertia"] * inertia, "axis.friction.viscous": 0.02 * viscous}
        moved_to(fits, named, values)
        return [
            one
            for one in remarks(rig, [log], [0], base, [fits.known(named)], uncertainty(base), (), RemarkSettings())
            if one.startswith("with what is named")
        ]

    assert said(4.9, 0.21) == []
    assert said(6.0, 0.1) == [
        "with what is named, numbers are far from the rig file's: axis.friction.viscous (0.1 times), axis.inertia (6 times); "
        "where that cannot be, the name stands in for something else"
    ]
    (known,) = said(6.0, 0.1, replace(rig, guessed=("axis.inertia",)))
    assert "axis.friction.viscous (0.1 times); where" in known


def test_a_dead_zone_between_two_commands_is_remarked_on() -> None:
    rig, named = platform("viscous = 0.02"), Hypothesis(("drive.deadzone",))
    steps = 0.9 * np.sign(np.sin(1.7 * TIME)) * (TIME > 0.6)
    y = run(rig, record(TIME, steps), {}, effects={"drive.deadzone": {"u_0": 0.3}})["yaw_rad"]
    log = record(TIME, steps, {"yaw_rad": y + np.random.default_rng(0).normal(0.0, 2e-4, len(y))})
    fits = fits_of(rig, log)
    SuccessiveHalving(fits).fit([named], Hypothesis())
    moved_to(fits, named, {"drive.deadzone.u_0": 0.3})
    found, base = fits.known(named), fits(Hypothesis())
    spread = uncertainty(base)
    said = remarks(rig, [log], [0], base, [found], spread, (), RemarkSettings())
    assert any(
        one.startswith("no command lies between 0 and 0.9 V") and "the 0.3 V of drive.deadzone" in one for one in said
    )
    wide = replace(RemarkSettings(), wide=1.0)
    assert not any("no command lies" in one for one in remarks(rig, [log], [0], base, [found], spread, (), wide))
