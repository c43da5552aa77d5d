import subprocess
import sys

import pytest

BODY = """
import importlib.abc, sys

OPTIONAL = ("torch", "stable_baselines3", "matplotlib", "pandas", "pyarrow", "cma", "typer", "rich")

class Missing(importlib.abc.MetaPathFinder):
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in OPTIONAL and BLOCK:
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)

sys.meta_path.insert(0, Missing())

import gymnasium as gym
import grind_env

for name in [name for name in gym.registry if name.startswith("grind/")]:
    env = gym.make(name)
    env.reset(seed=0)
    env.step(env.action_space.sample())
    vector = gym.make_vec(name, num_envs=3)
    vector.reset(seed=0)
    vector.step(vector.action_space.sample())
    print(name)

print([name for name in OPTIONAL if name in sys.modules])
"""


@pytest.mark.parametrize("block", [False, True])
def test_every_env_loads_and_needs_no_optional_package(block: bool) -> None:
    script = BODY.replace("BLOCK", str(block))
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    *ids, loaded = done.stdout.splitlines()
    assert {"grind/PowerLimited-v0", "grind/Oracle6-v0"} <= set(ids)
    assert loaded == "[]"
