from dataclasses import replace

import gymnasium as gym
import pytest

from grind_env.envs.ids import wide_plates
from grind_env.envs.tasks import TaskError, read_task

ID = "grind/WidePlates-v0"


def test_a_cycle_that_does_not_suit_the_wheel_is_refused() -> None:
    task = read_task("wide_plates")
    with pytest.raises(TaskError, match=r"^a plate of wide_plates is 60 mm wide, the wheel 25 mm: a G82 .*cross_pick"):
        replace(task, cross_pick=0.0)
    with pytest.raises(TaskError, match=r"^a plate of wide_plates is 25 mm wide, the wheel 25 mm: .*leave out cross"):
        replace(task, kinds=(replace(task.kinds[0], width=25.0),))
    for make in (gym.make, gym.make_vec):
        with pytest.raises(TaskError, match=r"^cycle is 'G82', but the blocks of wide_plates are G83"):
            make(ID, cycle="G82")
        with pytest.raises(TaskError, match=r"^cycle is 'G83', but the blocks of wide_rails are G82"):
            make("grind/WideRails-v0", cycle="G83")
    with pytest.raises(TaskError, match=r"^cycle is 'G84', but must be one of G81, G82, G83"):
        wide_plates.make(cycle="G84")
    assert gym.make("grind/WideRails-v0", cycle="G82").unwrapped.task.cycle == "G82"


def test_a_task_that_no_g83_can_grind_is_refused() -> None:
    task = read_task("wide_plates")
    with pytest.raises(TaskError, match=r"several kinds"):
        replace(task, kinds=(*task.kinds, replace(task.kinds[0], name="rail")))
    for pick in (0.1, 26.0):
        with pytest.raises(
            TaskError, match=r"^cross_pick is .*from 0.175 mm \(200 strokes\) to the width of the wheel, 25"
        ):
            replace(task, cross_pick=pick)
    with pytest.raises(TaskError, match=r"does not make 16 blocks of whole parts"):
        replace(task, kinds=(replace(task.kinds[0], ends_part=False),), sequence=("plate",))
