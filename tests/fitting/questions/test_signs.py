"""Readings without their sign are asked about, and those that keep it, whatever else is wrong with them, are not."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from rwjax.fitting.questions.likeness import Run
from rwjax.fitting.questions.signs import about_lost_signs
from tests.fitting.questions.runs import LOGS, TIME, beside
from tests.systems import platform, record, run

COSINE = record(TIME, np.where(TIME < 0.6, 0.0, 4.0 * np.cos(3.0 * (TIME - 0.6))), {"yaw_rad_s": np.zeros(len(TIME))})
NOISE = 1e-2 * np.random.default_rng(6).normal(size=len(TIME))
RUBBED = replace(
    COSINE, outputs={"yaw_rad_s": run(platform("viscous = 0.025\ncoulomb = 0.07"), COSINE, {})["yaw_rad_s"] + NOISE}
)
RUNS = {"square": beside(LOGS[0]), "cosine": beside(RUBBED)}
ONE_WAY = beside(LOGS[1])


def read(one: Run, values: np.ndarray) -> Run:
    return one._replace(log=replace(one.log, outputs={"yaw_rad_s": values}))


def rate(one: Run) -> np.ndarray:
    return one.log.outputs["yaw_rad_s"]


@pytest.mark.parametrize("factor", [1.0, 0.6, 9.55])
@pytest.mark.parametrize("name", RUNS)
def test_the_size_of_a_rate_is_asked_about_whatever_its_unit(name: str, factor: float) -> None:
    ((output, question),) = about_lost_signs([read(RUNS[name], factor * np.abs(rate(RUNS[name])))]).items()
    assert output == "yaw_rad_s" and question.startswith(
        "yaw_rad_s never goes below 0, and follows the command of both"
    )
    assert question.endswith("Give yaw_rad_s = { …, unsigned = true } in [columns]")


def test_missing_readings_and_a_log_that_goes_one_way_do_not_matter_and_one_of_both_signs_does() -> None:
    sizes = [
        read(one, np.where(np.arange(len(TIME)) % 4 == 1, np.nan, np.abs(rate(one))))
        for one in (*RUNS.values(), ONE_WAY)
    ]
    assert [*about_lost_signs(sizes)] == ["yaw_rad_s"]
    assert about_lost_signs(sizes[2:]) == about_lost_signs([*sizes[:2], ONE_WAY]) == {}


def one_way(one: Run) -> np.ndarray:
    return np.maximum(rate(one), 0.0)


def about_an_offset(one: Run) -> np.ndarray:
    return rate(one) - np.min(rate(one)) + 1.0


def far_above_zero(one: Run) -> np.ndarray:
    return rate(one) + 50.0 * np.max(np.abs(rate(one)))


def of_another_run(one: Run) -> np.ndarray:
    return np.abs(rate(one))[::-1].copy()


def weaker_one_way(one: Run) -> np.ndarray:
    return np.where(rate(one) > 0.0, rate(one), -0.4 * rate(one))


def constant(one: Run) -> np.ndarray:
    return np.full(len(TIME), 3.0)


@pytest.mark.parametrize(
    "reading", [rate, one_way, about_an_offset, far_above_zero, of_another_run, weaker_one_way, constant]
)
@pytest.mark.parametrize("name", RUNS)
def test_a_reading_that_is_no_size_is_not_asked_about(name: str, reading: Callable[[Run], np.ndarray]) -> None:
    assert about_lost_signs([read(RUNS[name], reading(RUNS[name]))]) == {}


def test_a_side_of_which_nothing_was_read_is_no_sign_of_a_size() -> None:
    one = RUNS["cosine"]
    assert about_lost_signs([read(one, np.where(one.simulated["yaw_rad_s"] > 0.0, np.abs(rate(one)), np.nan))]) == {}
    assert about_lost_signs([read(one, np.full(len(rate(one)), np.nan))]) == {}


def test_an_angle_has_no_sign_to_lose() -> None:
    angle = replace(LOGS[0], outputs={"yaw_rad": np.abs(LOGS[0].outputs["yaw_rad"])})
    assert about_lost_signs([RUNS["square"]._replace(log=angle)]) == {}
