"""Page of one id: description, spaces, reward, episode, arguments, scores, example, versions."""

import inspect
import math
import re
from collections.abc import Callable
from typing import Any

from grind_env.data_table import table_of
from grind_env.envs.cost import COST_TERMS, reward_terms
from grind_env.envs.docstring_sections import meanings
from grind_env.envs.learning_scales import WORST_REWARD
from grind_env.pages import task_tables
from grind_env.pages.nominal_interval import SAVINGS_LEFT, dress_interval
from grind_env.pages.reward_bounds import RewardSpan
from grind_env.pages.task_page_data import TaskSheet, sheet
from grind_env.score_scale import EPISODES, find_reference, normalise
from grind_env.task_version import HISTORY, TASK_VERSION

HEADING = re.compile(r"^## (.+)$", re.MULTILINE)


def prose(make: Callable[..., Any]) -> dict[str, str]:
    """Return the text of a docstring by section, that is by `## Heading`; its first line is the section ""."""
    text = re.split(r"^(?:Args|Raises):$", inspect.cleandoc(make.__doc__ or ""), flags=re.MULTILINE)[0]
    first, *parts = HEADING.split(text)
    return {"": first.strip(), **{name: body.strip() for name, body in zip(parts[::2], parts[1::2], strict=True)}}


def arguments(make: Callable[..., Any]) -> list[tuple[str, str, str]]:
    """Return name, default and meaning of every argument; the meaning is from `Args:` of the docstring."""
    said = meanings(make, "Args")
    parameters = inspect.signature(make).parameters.values()
    return [
        (each.name, "" if each.default is each.empty else repr(each.default), said.get(each.name, ""))
        for each in parameters
    ]


def page(env_id: str) -> str:
    """Return the page of a registered id, Markdown.

    Raises:
        PageError: if the id is not registered or has no notes.
    """
    about = sheet(env_id)
    words = prose(about.make)
    parts = {
        "Description": _description(about, words),
        "Action space": _actions(about),
        "Observation space": _observation(about),
        "Reward": _reward(about),
        "Episode": _episode(about),
        "Arguments": _arguments(about),
        "Reference scores": _scores(about),
        "Example": _example(about),
        "Version history": _versions(about),
    }
    lines = [f"# {about.id}", f"*{about.title}.*", _facts(about)]
    for name, part in parts.items():
        own = "" if name == "Description" else words.get(name, "")
        lines += [f"## {name}", own, part]
    return "\n\n".join(line for line in lines if line) + "\n"


def _facts(about: TaskSheet) -> str:
    seen = about.env.observation_space
    rows = [
        ("make", f'`gym.make("{about.id}"{", program=..." if about.note.program else ""})`'),
        ("action space", f"`{about.env.action_space}`"),
        ("observation space", f"`Box({seen.shape}, {seen.dtype})`"),
        ("steps", f"{about.steps}" if about.steps else "not fixed"),
        ("reward of a step", _span(about.reward)),
        ("recommended discount", _discount(about)),
        ("task version", str(TASK_VERSION)),
        ("difficulty", about.note.hard),
    ]
    return table_of(("", ""), rows).markdown()


def _example(about: TaskSheet) -> str:
    session = f"```python\n{example(about)}\n```"
    return (
        "To learn it: `VectorForLearning` of `grind_env.envs.wrappers` standardises the observation, adds 1 to the"
        f" reward and clips it at {WORST_REWARD:g}."
        ' With these, `action="multidiscrete"` and `SB3VecEnv` of `grind_env.sb3`, PPO of Stable-Baselines3 learns: the'
        f" recipe is in `docs/howto/train.md`.\n\n{session}"
    )


def _versions(about: TaskSheet) -> str:
    lines = [
        table_of(("version", "what changed"), about.note.versions.items()).markdown(),
        f"Ids stay `-v0` until 1.0. The tasks are of version {TASK_VERSION}; scores, tuned parameters and agents of"
        " other versions are refused.",
        table_of(("task version", "what it is"), HISTORY.items()).markdown(),
    ]
    return "\n\n".join(lines)


def _discount(about: TaskSheet) -> str:
    env = about.env
    env.reset(seed=0, options={"context": "nominal"})
    interval = dress_interval(env.simulation, env.given)
    every = "step" if interval == 1 else f"{interval} steps"
    return (
        f"{SAVINGS_LEFT ** (1.0 / interval):.4f}: the cheapest fixed plan without randomness dresses every {every}; a"
        f" reward at the next dress still counts {SAVINGS_LEFT:g}"
    )


def _span(reward: RewardSpan) -> str:
    return f"{reward.least:g} to {reward.most:g}" if math.isfinite(reward.least) else f"at most {reward.most:g}"


def _description(about: TaskSheet, words: dict[str, str]) -> str:
    lines = [about.note.summary, words[""], words.get("Description", "")]
    if about.task is not None:
        order = "random orders" if about.task.orders else ", ".join(about.task.sequence) + ", repeated"
        lines += [
            f"Blocks: {about.task.blocks}, {order}.",
            task_tables.kind_table(about, about.task),
            task_tables.setup_table(about.task),
        ]
    return "\n\n".join(lines)


def _actions(about: TaskSheet) -> str:
    forms = task_tables.form_table(about.env.codec.task, predress=about.task is not None)
    return f"{task_tables.action_table(about)}\n\n{forms}"


def _observation(about: TaskSheet) -> str:
    shown = dict(enumerate(about.readings))
    hidden = {place: each for place, each in enumerate(about.full) if each not in about.readings}
    lines = [
        f"{len(shown)} entries; with an entry x of the observation, `value` is what was read, in its unit.",
        task_tables.observation_table(shown),
    ]
    if hidden:
        lines += [
            f'`observation="full"` has {len(about.full)} entries: these come after them.',
            task_tables.observation_table(hidden),
        ]
    return "\n\n".join(lines)


def _reward(about: TaskSheet) -> str:
    bounded = math.isfinite(about.reward.least)
    lines = [f"A step earns {'from ' if bounded else ''}{_span(about.reward)}."]
    if about.task is not None:
        lines[0] += f" The reference cost is {about.task.reference_cost:.4g} $ a step. {task_tables.RANGE_NOTE}"
        lines.append(task_tables.reward_table(about.costs, about.task.reference_cost))
    return "\n\n".join(lines)


def _episode(about: TaskSheet) -> str:
    if about.task is None:
        return ""
    start = about.task.start
    lines = [f"It is `terminated` after block {about.task.blocks}, never `truncated`. An action cannot end it."]
    if start.wear_flat_area is not None:
        lines.append(
            f"The wheel starts with a wear-flat area of {start.wear_flat_area:g}, {start.volume:g} mm3/mm old."
        )
    if factors := ", ".join(f"{name} {value:g}" for name, value in about.task.factors.items()):
        lines.append(f"Fixed factors: {factors}.")
    drawn = task_tables.drawn_table(about.task)
    lines.append("Drawn at reset:" if drawn else "Nothing is drawn: all episodes are the same.")
    return "\n\n".join([" ".join(lines), drawn] if drawn else [" ".join(lines)])


def _arguments(about: TaskSheet) -> str:
    fixed = about.env.spec.kwargs if about.env.spec else {}
    rows = [
        (f"`{name}`", f"`{default}`" if default else "required", meaning)
        for name, default, meaning in arguments(about.make)
        if name != "task" or name not in fixed
    ]
    return table_of(("argument", "default", "meaning"), rows).markdown()


def _scores(about: TaskSheet) -> str:
    known = find_reference(about.id)
    if known is None:
        return "None measured yet."
    rows = [
        (policy, f"{mean.value:.4g} ± {mean.error:.2g}", f"{normalise(about.id, mean.value):.4g}")
        for policy, mean in known.returns.items()
    ]
    heading = f"cost over that of {known.fixed_plan}" if known.ratio else "score"
    scale = "" if known.ratio else f" The score is linear in the return: 0 is {known.fixed_plan}, 100 hindsight."
    listed = table_of(("policy", "return", heading), rows).markdown()
    return (
        f"Mean return over {EPISODES} evaluation episodes, with standard error, by `python -m agents scores`.{scale} "
        f"The benchmark has more episodes, these included: its scores differ by chance.\n\n{listed}"
    )


COUNT = 4  #: number of environments in the vector environment of the example


def example(about: TaskSheet) -> str:
    """Return a session that makes the environment, takes one step, and makes the vector environment."""
    env = about.env
    size, width = len(about.readings), env.action_space.shape[0]
    lines = [">>> import gymnasium as gym", ">>> import grind_env"]
    program = ""
    if about.note.program:
        lines.append(f'>>> program = grind_env.examples.path("{about.note.program}")')
        program = ", program=str(program)"
    lines += [
        f'>>> env = gym.make("{about.id}"{program})',
        ">>> env.action_space",
        repr(env.action_space),
        ">>> observation, info = env.reset(seed=1)",
        ">>> observation.shape",
        f"({size},)",
        ">>> env.unwrapped.observation_info()[0].name",
        repr(about.readings[0].name),
        ">>> observation, reward, terminated, truncated, info = env.step(env.action_space.low)",
        ">>> terminated, truncated",
        f"({about.steps == 1}, False)",
    ]
    least = f"{about.reward.least:g} <= " if math.isfinite(about.reward.least) else ""
    lines += [f">>> {least}reward <= {about.reward.most:g}", "True"]
    terms = COST_TERMS if about.task is None else reward_terms(about.task)
    names = [f"reward_{name}" for name in terms]
    lines += ['>>> [name for name in info if name.startswith("reward_")]', repr(names)]
    lines += [
        '>>> info["E"], info["D"]',
        f"({env.codec.low}, 0.0)",
        f'>>> vector = gym.make_vec("{about.id}", num_envs={COUNT}{program})',
        ">>> observations, infos = vector.reset(seed=1)",
        ">>> observations.shape, vector.action_space.shape",
        f"(({COUNT}, {size}), ({COUNT}, {width}))",
    ]
    return "\n".join(lines)
