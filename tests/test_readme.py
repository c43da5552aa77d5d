import re
import subprocess
import sys
from pathlib import Path

import gymnasium as gym
import numpy as np

import grind_env

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")


def test_the_examples_run_one_after_the_other(tmp_path):
    examples = "\n".join(re.findall(r"```python\n(.*?)```", README, re.DOTALL))
    assert examples.count("1_000_000") == 1
    script = examples.replace("1_000_000", "7_680")
    run = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True, cwd=tmp_path)
    *evaluated, power = run.stdout.splitlines()
    assert sum("$ per good part (" in line for line in evaluated) == examples.count("grind_env.evaluate(") == 2
    record = grind_env.grind(grind_env.examples.path("plate_g82.nc"))
    assert float(power) == record.strokes["power"].max()


def test_the_task_file_of_the_guide_is_an_environment(tmp_path):
    guide = (ROOT / "docs" / "howto" / "task.md").read_text(encoding="utf-8")
    (content,) = re.findall(r'Path\("shop\.toml"\)\.write_text\("""\n(.*?)"""\)', guide, re.DOTALL)
    file = tmp_path / "shop.toml"
    file.write_text(content, encoding="utf-8")
    env = gym.make("grind/Task-v0", task=str(file))
    env.reset(seed=1)
    assert np.isfinite(env.step(env.action_space.sample())[1])
    constant = re.search(r"grind evaluate --task shop\.toml --policy (\w+)", guide)[1]
    assert len(grind_env.evaluate(constant, str(file), episodes=2).evaluation.cost) == 2


def paths(text: str) -> list[str]:
    """The paths that a text links or names."""
    found = re.findall(r"\]\(([\w./-]+)\)|`((?:grind_env|agents|notebooks|docs|tests)/[\w./]+)`", text)
    return [first or second for first, second in found]


def test_the_files_it_names_are_there():
    assert paths(README)
    for path in paths(README):
        assert (ROOT / path).exists(), path


def test_the_files_to_change_are_there():
    page = (ROOT / "docs" / "where-to-change-what.md").read_text(encoding="utf-8")
    drawn = re.findall(r"(?<![\w/])(?:control|machine|process|envs)/\w+\.py", page)
    for path in [*paths(page), *(f"grind_env/{path}" for path in drawn)]:
        assert (ROOT / path).exists(), path


def test_the_commands_it_names_exist():
    targets = re.findall(r"^([\w-]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE)
    assert set(re.findall(r"make ([a-z]+)", README)) <= set(targets)


def test_it_is_short():
    assert len(README.splitlines()) < 130
