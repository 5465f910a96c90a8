"""Laws outside the list of effects: what they do, and that no rig file and no answer has one."""

import numpy as np
import pytest

from rwjax import RigError, parse_rig, write_rig
from rwjax.diagnosis.hypothesis import candidates
from rwjax.effects.library import BY_NAME, UNLISTED, of_kind, passing_for
from rwjax.kinds import KINDS
from rwjax.plant.from_rig import structure_of
from tests.systems import platform, record, run

GROWS = "axis.growing_stiction"
GAIN, M_C, M_E, TAU = 0.4, 0.05, 0.1, 2.0  # N m/V, N m, N m, s


def rates(command: np.ndarray, t: np.ndarray) -> np.ndarray:
    return run(platform(), record(t, command), {}, effects={GROWS: {"M_e": M_E, "tau": TAU}})["yaw_rad_s"]


def test_a_ramp_breaks_away_where_it_meets_the_grown_level() -> None:
    t = np.arange(1001) * 0.01
    w = rates(0.05 * t, t)
    level = M_C + M_E * (1.0 - np.exp(-t / TAU))
    away = t[np.flatnonzero(GAIN * 0.05 * t > level)[0]]
    assert 4.0 < away < 8.0 and t[np.flatnonzero(w)[0]] == pytest.approx(away, abs=0.02)


def test_sliding_friction_is_the_rigs_own_and_the_time_at_rest_begins_anew_after_it() -> None:
    t = np.arange(801) * 0.01
    u = np.select([t < 3.0, t < 4.0, t < 4.3, t < 5.5], [0.0, 0.25, 0.5, 0.0], 0.25)
    w = rates(u, t)
    assert np.all(w[t < 4.0] == 0.0)  # 0.1 N m against 0.05 + 0.1 (1 - exp(-3/2)) = 0.13 N m
    assert np.any(w[(t > 4.0) & (t < 4.3)] > 0.0) and np.all(w[(t > 5.3) & (t < 5.5)] == 0.0)
    assert np.all(w[t > 5.52] > 0.0)  # the same 0.1 N m after 0.3 s of rest
    slides, values = (t > 5.6) & (t < 6.0), platform().values
    drag = values["axis.friction.viscous"] * (w[1:] + w[:-1]) / 2.0
    torque = (values["axis.inertia"] * np.diff(w) / 0.01 + drag)[slides[1:]]
    assert torque == pytest.approx(GAIN * 0.25 - M_C, rel=1e-3)


@pytest.mark.parametrize("kind", KINDS)
def test_no_rig_file_and_no_answer_has_one(kind: str) -> None:
    assert not {law.name for law in UNLISTED} & {*of_kind(kind)}


def test_what_a_rig_file_with_one_is_told() -> None:
    with pytest.raises(RigError, match=f"no effect `{GROWS}`"):
        parse_rig(write_rig(platform()) + f'\n[effects."{GROWS}"]\nM_e = 0.1\ntau = 2.0\n')
    assert GROWS not in candidates(platform())


def test_each_passes_for_an_effect_of_the_list_and_its_programs_are_kept() -> None:
    for law in UNLISTED:
        assert law.passes_for and all(not BY_NAME[name].passes_for for name in law.passes_for)
    assert passing_for("axis.stribeck") == (GROWS,) and passing_for("pitch.stribeck") == ("pitch.growing_stiction",)
    assert passing_for("axis.coulomb") == () == passing_for("parameter.axis.inertia")
    assert structure_of(platform()).with_effects(GROWS).from_library
