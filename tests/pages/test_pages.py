import ast
import doctest
import itertools
import json
import math
import re
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest

from grind_env.envs.observations import physical
from grind_env.pages import PageError, page, page_ids
from grind_env.pages.__main__ import write
from grind_env.pages.nominal_interval import dress_interval
from grind_env.pages.plants import plants_page
from grind_env.pages.task_notes import load_notes, note_of
from grind_env.pages.task_page import arguments, prose
from grind_env.pages.task_page_data import TaskSheet, sheet
from grind_env.plants import FAMILIES, find_plant
from grind_env.task_version import TASK_VERSION
from tests.command import Grind
from tests.envs.harness import IDS, Array, reward_terms_of

#: expected `own_text("grind/Oracle6-v0")`; rewrite the file after an intended change
GOLDEN = Path(__file__).with_name("page_oracle6.md")

EVERY = page_ids()
TASKS = [env_id for env_id in EVERY if env_id != "grind/Job-v0"]

every_id = pytest.mark.parametrize("env_id", EVERY)
every_task = pytest.mark.parametrize("env_id", TASKS)

SHARP = {"pm": 0.2, "kA": 0.05, "wheel_kA": 0.05, "diamond_flat": 0.0, "fc": 0.25, "Gref": 0.2}
SHARP |= {"material": "grey_cast_iron"}
"""Context in which the fastest table stalls no spindle: an easy material and a soft wheel that wears away."""
#: context in which the slowest table stalls every spindle at some time
DULL = {"pm": 5.0, "kA": 20.0, "wheel_kA": 20.0, "fc": 5.0, "diamond_flat": 0.5}

SECTIONS = """Description, Action space, Observation space, Reward, Episode, Arguments, Reference scores, Example,
Version history"""


def section(text: str, name: str) -> str:
    return re.split(r"^## ", text.partition(f"\n## {name}\n")[2], flags=re.MULTILINE)[0]


def tables(text: str) -> list[list[list[str]]]:
    """Return the cells of the body rows of every table."""
    found = re.findall(r"(?:^\|.*\|\n?)+", text, re.MULTILINE)
    return [[[cell.strip() for cell in line.split("|")[1:-1]] for line in one.splitlines()[2:]] for one in found]


def arguments_of(about: TaskSheet) -> dict[str, Any]:
    return dict(about.env.spec.kwargs) if about.env.spec else {}


def test_every_registered_id_has_a_page() -> None:
    assert set(EVERY) == {name for name in gym.registry if name.startswith("grind/")}
    assert set(IDS) <= set(EVERY)


@every_id
def test_a_page_has_every_section(env_id: str) -> None:
    text = page(env_id)
    assert text.startswith(f"# {env_id}\n")
    headings = re.findall(r"^## (.+)$", text, re.MULTILINE)
    assert headings == [name.strip() for name in SECTIONS.split(",")]
    assert all(section(text, name).strip() for name in headings)


@every_id
def test_the_action_table_matches_the_action_space(env_id: str) -> None:
    space: Any = sheet(env_id).env.action_space
    rows = tables(section(page(env_id), "Action space"))[0]
    assert [int(row[0]) for row in rows] == list(range(space.shape[0]))
    assert [float(row[2]) for row in rows] == space.low.tolist()
    assert [float(row[3]) for row in rows] == space.high.tolist()


@every_id
def test_the_action_table_gives_the_E_and_D_of_both_ends(env_id: str) -> None:
    (speed, dresses), forms = tables(section(page(env_id), "Action space"))
    env: Any = sheet(env_id).env
    (low, high), (least, most) = env.codec.decode([[-1.0, -1.0], [1.0, 1.0]])
    named = [float(number) for number in re.findall(r"\d+", speed[4].partition(" mm/min")[0])]
    assert [named[0], named[-1]] == [low, high]
    assert dresses[4].startswith(f"{least:.0f} to {most:.0f} dress executions: none up to 1/3")
    spaces = {}
    for argument, space in forms:
        name, value = argument.strip("`").split("=")
        spaces[argument] = str(gym.make(env_id, **{name: ast.literal_eval(value)}).action_space)
        assert space == f"`{spaces[argument]}`"
    # grind/Job-v0 has no form with a pre-dress
    assert len(set(spaces.values())) == (5 if env_id in TASKS else 4)


@every_id
@pytest.mark.parametrize("full", [False, True])
def test_the_observation_table_matches_the_observation_space(env_id: str, full: bool) -> None:
    about = sheet(env_id)
    measured, *hidden = tables(section(page(env_id), "Observation space"))
    space: Any = about.env.observation_space
    assert [int(row[0]) for row in measured] == list(range(space.shape[0]))
    if full and not hidden:
        assert "observation" not in dict(inspect_arguments(about)) or about.full == about.readings
        return
    rows, readings = (hidden[0], about.full) if full else (measured, about.readings)
    if full:
        space = gym.make(env_id, observation="full", **arguments_of(about)).observation_space
        assert len(measured) + len(rows) == space.shape[0]
    middle = 0.5 * (space.low.astype(float) + space.high)
    values = physical(middle, readings)
    for row in rows:
        place, name = int(row[0]), row[1].strip("`")
        np.testing.assert_allclose([float(row[2]), float(row[3])], [space.low[place], space.high[place]], rtol=1e-5)
        assert value_of(row[4], middle[place]) == pytest.approx(float(values[name]), rel=1e-5, abs=1e-9)
        assert readings[place].name == name and row[6] and row[7]


def value_of(formula: str, x: float) -> float:
    """Return the value of `a + b x`, where a or b may be missing."""
    match = re.fullmatch(r"(?:([-\d.e]+) \+ )?(?:([-\d.e]+) )?x", formula)
    assert match, formula
    return float(match[1] or 0.0) + float(match[2] or 1.0) * x


def inspect_arguments(about: TaskSheet) -> list[tuple[str, str]]:
    return [(name, meaning) for name, _, meaning in arguments(about.make)]


@every_id
def test_every_argument_is_explained(env_id: str) -> None:
    about = sheet(env_id)
    rows = tables(section(page(env_id), "Arguments"))[0]
    fixed = {"task"} & set(arguments_of(about))
    assert [row[0].strip("`") for row in rows] == [name for name, _ in inspect_arguments(about) if name not in fixed]
    assert all(row[2] for row in rows)


@every_id
def test_the_example_runs(env_id: str) -> None:
    example = section(page(env_id), "Example").strip().removeprefix("```python\n").removesuffix("\n```")
    test = doctest.DocTestParser().get_doctest(example + "\n", {}, env_id, None, None)
    report: list[str] = []
    result = doctest.DocTestRunner().run(test, out=report.append)
    assert result.failed == 0, "".join(report)
    assert result.attempted >= 10


def play(env_id: str, action: Array | None, episodes: int, context: dict[str, Any] | None) -> list[dict[str, Any]]:
    """Return rewards and reward terms of all steps, with one action or with random ones."""
    about = sheet(env_id)
    env = gym.make_vec(env_id, episodes, autoreset_mode="Disabled", **arguments_of(about))
    env.action_space.seed(1)
    env.reset(seed=1, options=None if context is None else {"context": context})
    steps = []
    for _ in range(about.steps):
        actions = env.action_space.sample() if action is None else np.tile(action, (episodes, 1))
        _, rewards, _, _, info = env.step(actions)
        terms = reward_terms_of(info)
        steps.append({"reward": rewards, **terms})
    return steps


@every_task
def test_the_reward_lies_in_the_range_that_the_page_states(env_id: str) -> None:
    text = section(page(env_id), "Reward")
    match = re.search(r"A step earns from (\S+) to (\S+)\. ", text)
    assert match
    low, high = float(match[1]), float(match[2])
    terms = {row[0].strip("`"): (float(row[2]), float(row[3])) for row in tables(text)[0]}
    corners = [np.array(corner, np.float32) for corner in itertools.product([-1.0, 1.0], repeat=2)]
    steps = [step for action in [None, *corners] for step in play(env_id, action, 32, None)]
    for name, (worst, best) in terms.items():
        values = np.array([step[name] for step in steps])
        assert values.min() >= worst - 0.005 and values.max() <= best + 0.005, name
    rewards = np.array([step["reward"] for step in steps])
    assert low <= rewards.min() and high >= rewards.max()
    # the lower end is not far out: hard blocks, in which the spindle stalls, come near it
    hard = [step["reward"] for step in play(env_id, corners[1], 8, DULL)]
    assert min(rewards.min(), np.min(hard)) < 0.4 * low


@every_task
def test_the_stated_range_of_the_time_cost_is_reached(env_id: str) -> None:
    about = sheet(env_id)
    assert about.task is not None
    spread = about.task.spread.stock
    span = about.costs["time"]
    least = min(kind.least_stock for kind in about.task.kinds)
    for corner, stock, wheel, end in (
        ((1.0, -1.0), least if spread else 1.0, SHARP, span.least),
        ((-1.0, 1.0), 1.0 + 6.0 * spread, DULL, span.most),
    ):
        steps = play(env_id, np.array(corner, np.float32), 8, {"stock": stock, **wheel})
        costs = -about.task.reference_cost * np.array([step["time"] for step in steps])
        extreme = costs.min() if end == span.least else costs.max()
        # the literal G81, which has no pick, waits for its reversal points: its ends are bounds, the others are exact
        exact = 1e-9 if any(each.name == "pick" for each in about.readings) else 0.08
        assert extreme == pytest.approx(end, rel=exact)
        assert span.least * (1.0 - 1e-9) <= costs.min() and costs.max() <= span.most * (1.0 + 1e-9)


def test_the_page_of_a_job_says_that_its_reward_has_no_lower_bound() -> None:
    text = page("grind/Job-v0")
    assert "| reward of a step | at most 0 |" in text
    assert "No lower bound is known: " in section(text, "Reward")
    assert sheet("grind/Job-v0").reward == (-math.inf, 0.0)


@every_id
def test_the_history_ends_with_the_version_of_the_id(env_id: str) -> None:
    versions = [row[0] for row in tables(section(page(env_id), "Version history"))[0]]
    assert versions[-1] == env_id.rpartition("-")[2]
    assert all(load_notes()[env_id].versions.values())


def test_the_name_of_a_task_gives_the_page_of_its_id() -> None:
    assert page("wide_rails") == page("grind/WideRails-v0")


def test_an_id_without_a_page_is_refused() -> None:
    with pytest.raises(
        PageError, match=r"^there is no environment 'grind/Rush' \(did you mean grind/Rush-v0\?\); the ids"
    ):
        page("grind/Rush")
    with pytest.raises(PageError, match=r"^grind/Lathe-v0 has no notes: add a table of that name to notes\.toml$"):
        note_of("grind/Lathe-v0")


def own_text(env_id: str) -> str:
    """Return a page without the text copied from the docstring of the environment."""
    text = page(env_id)
    for name, words in prose(sheet(env_id).make).items():
        assert words in text
        text = text.replace(words, f"<docstring: {name or 'first words'}>")
    return text.replace(section(text, "Arguments"), "\n<docstring: Args>\n\n")


def test_the_page_of_oracle6_matches_the_stored_page() -> None:
    assert own_text("grind/Oracle6-v0") == GOLDEN.read_text(encoding="utf-8")


@pytest.mark.nightly
def test_the_index_leads_to_every_page(tmp_path: Path) -> None:
    files = write(tmp_path / "docs")
    text = (tmp_path / "docs" / "index.md").read_text(encoding="utf-8")
    links = re.findall(r"\[(grind/[^\]]+)\]\(([^)]+)\)", text)
    assert [name for name, _ in links] == EVERY
    others = {"index.md", "fields.md", "plants.md", "validation.md", "validation.png", "validation.csv"}
    assert {path.name for path in files} == others | {link for _, link in links}
    assert "](validation.md)" in text
    assert "](fields.md)" in text
    for name, link in links:
        assert (tmp_path / "docs" / link).read_text(encoding="utf-8") == page(name)


def test_grind_tasks_lists_every_id(grind: Grind) -> None:
    status, out, err = grind("tasks")
    assert (status, err) == (0, "")
    assert all(f"\n{env_id} " in out for env_id in EVERY)


def test_grind_tasks_prints_json(grind: Grind) -> None:
    found = json.loads(grind("tasks", "--json")[1], parse_constant=pytest.fail)
    assert [one["id"] for one in found] == EVERY
    (rush,) = (one for one in found if one["id"] == "grind/Rush-v0")
    assert (rush["steps"], rush["observation"], rush["full"]) == (96, 33, 45)
    assert rush["actions"] == ["box", "multidiscrete", "discrete", "dict"]
    assert all(len(one["actions"]) == 4 for one in found)
    assert {one["id"]: one["reward"] for one in found if one["reward"][0] is None} == {"grind/Job-v0": [None, 0.0]}
    assert json.loads(grind("tasks", "grind/Rush-v0", "--json")[1]) == [rush]


def test_grind_tasks_prints_a_page(grind: Grind) -> None:
    assert grind("tasks", "grind/Slot-v0") == (0, page("grind/Slot-v0"), "")
    status, out, err = grind("tasks", "grind/Rash-v0")
    assert (status, out) == (2, "")
    assert err.startswith("grind: there is no environment 'grind/Rash-v0' (did you mean grind/Rush-v0?)")
    assert err.count("\n") == 1


def facts(env_id: str) -> dict[str, str]:
    """Return the rows of the first table of a page."""
    return {row[0]: row[1] for row in tables(page(env_id).partition("\n## ")[0])[0]}


@every_id
def test_every_page_gives_its_task_version_and_the_earlier_versions(env_id: str) -> None:
    assert facts(env_id)["task version"] == str(TASK_VERSION)
    _, versions = tables(section(page(env_id), "Version history"))
    assert [row[0] for row in versions] == [str(number) for number in range(1, TASK_VERSION + 1)]
    assert all(row[1] for row in versions)


@every_id
def test_the_recommended_discount_follows_from_the_dress_interval(env_id: str) -> None:
    said = facts(env_id)["recommended discount"]
    (discount,) = re.findall(r"^0\.\d{4}", said)
    every = re.search(r"dresses every (?:(\d+) )?step", said)
    assert every
    steps = int(every[1] or 1)
    assert float(discount) ** steps == pytest.approx(0.9, abs=0.002 * steps**0.5)
    about = sheet(env_id)
    assert 1 <= steps <= (about.steps or 10_000)


@pytest.mark.parametrize("name", ["PowerLimited", "WideRails"])
def test_other_dress_intervals_cost_more_on_the_nominal_episode(name: str) -> None:
    env: Any = gym.make(f"grind/{name}-v0", show_block=False).unwrapped
    low, high = env.task.action.speed_ends

    def least(interval: int) -> float:
        """Return the cost in $ of the nominal episode at the best of eight speeds."""
        costs = []
        for speed in np.round(np.geomspace(low, high, 8)):
            env.reset(seed=0, options={"context": "nominal"})
            plan = env.codec.encode([speed, speed], [0.0, 1.0])
            dressed = [int(k > 0 and k % interval == 0) for k in range(env.task.blocks)]
            costs.append(sum(env.step(plan[dress])[4]["block_cost"] for dress in dressed))
        return min(costs)

    env.reset(seed=0, options={"context": "nominal"})
    best = dress_interval(env.simulation, env.given)
    assert least(best) < min(least(best - 1), least(best + 1), least(2 * best))


def test_the_page_of_machines_lists_every_family_with_ranges_and_sources() -> None:
    page = plants_page()
    assert re.findall(r"^## (.+)$", page, re.MULTILINE) == [family.name for family in FAMILIES]
    span = r"(\S+) to (\S+?)(?:; held out (\S+) to (\S+?))?(, factor)?"
    rows = re.findall(rf"^\| `(\w+)` \| (.+) \| (.+) \| {span} \| (\w+): (.+) \|$", page, re.MULTILINE)
    ranges = [each for family in FAMILIES for each in family.ranges]
    assert [row[0] for row in rows] == [each.field for each in ranges]
    for row, each in zip(rows, ranges, strict=True):
        assert (float(row[3]), float(row[4]), bool(row[7])) == (each.low, each.high, each.factor)
        assert (float(row[5]), float(row[6])) == each.held_out if each.held_out else not row[5]
        assert (row[8], row[9]) == (each.basis.evidence.name.lower(), each.basis.text)


def test_plants_named_on_the_page_of_machines_exist() -> None:
    named = re.findall(r"^\| `([\w+:-]+)` \|", plants_page(), re.MULTILINE)
    assert len([find_plant(name) for name in named if not name.startswith("module:") and ":" in name]) == 7
