import re
import subprocess
import sys
from pathlib import Path

import gymnasium as gym
import numpy as np

import grind_env
from grind_env.policies.policy_lookup import named_policy
from grind_env.policies.problem_lookup import find_problem

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")


def test_the_example_prints_the_output_in_the_readme(tmp_path):
    (example,) = re.findall(r"```python\n(.*?)```", README, re.DOTALL)
    (printed,) = re.findall(r"```text\n(.*?)```", README, re.DOTALL)
    run = subprocess.run([sys.executable, "-c", example], capture_output=True, text=True, check=True, cwd=tmp_path)
    assert run.stdout == printed


def test_each_policy_name_of_the_results_table_is_known():
    names = re.findall(r"^\| (\w+) \| .* to ", README, re.MULTILINE)
    assert len(names) == 6
    simulation = find_problem("power_limited").simulation()
    for name in names:
        assert named_policy(name, simulation)


def test_the_task_file_of_the_guide_makes_an_environment(tmp_path):
    guide = (ROOT / "docs" / "howto" / "task.md").read_text(encoding="utf-8")
    (content,) = re.findall(r'Path\("rails\.toml"\)\.write_text\("""\n(.*?)"""\)', guide, re.DOTALL)
    file = tmp_path / "rails.toml"
    file.write_text(content, encoding="utf-8")
    env = gym.make("grind/Task-v0", task=str(file))
    env.reset(seed=1)
    assert np.isfinite(env.step(env.action_space.sample())[1])
    constant = re.search(r"grind evaluate --task rails\.toml --policy (\w+)", guide)[1]
    assert len(grind_env.evaluate(constant, str(file), episodes=2).evaluation.cost) == 2


def paths(text: str) -> list[str]:
    """Return the paths that a text links or names."""
    found = re.findall(r"\]\(([\w./-]+)\)|`((?:grind_env|agents|notebooks|docs|tests)/[\w./]+)`", text)
    return [first or second for first, second in found]


def test_files_named_in_the_readme_exist():
    assert paths(README)
    for path in paths(README):
        assert (ROOT / path).exists(), path


def test_files_named_in_the_change_guide_exist():
    page = (ROOT / "docs" / "where-to-change-what.md").read_text(encoding="utf-8")
    for ref in re.findall(r"(?<![\w/])(?:(?:\w+/)+(?:\w+\.(?:py|toml|csv|md))?|\w+\.py)(?![\w<])", page):
        assert any(any((ROOT / at).glob(ref if "/" in ref else f"**/{ref}")) for at in ("grind_env", ".", "docs")), ref


def test_make_targets_named_in_the_readme_exist():
    targets = re.findall(r"^([\w-]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE)
    assert set(re.findall(r"make ([a-z]+)", README)) <= set(targets)


def test_the_readme_is_short():
    assert len(README.split()) <= 700
    code = re.findall(r"```(?:sh|python)\n(.*?)```", README, re.DOTALL)
    assert len(code) == 3 and all(len(line) <= 80 for block in code for line in block.splitlines())
    paragraphs = re.sub(r"```.*?```", "", README, flags=re.DOTALL).split("\n\n")
    assert all(len(each.splitlines()) <= 4 for each in paragraphs if not each.lstrip().startswith(("|", "- ")))
