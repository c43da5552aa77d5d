import subprocess
import sys

BODY = """
import importlib.abc, sys

TRIED = []
OPTIONAL = ("torch", "stable_baselines3", "matplotlib", "pandas", "pyarrow", "cma", "typer", "rich")

class Missing(importlib.abc.MetaPathFinder):
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in OPTIONAL:
            TRIED.append(name)
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

print(TRIED)
"""


def test_every_env_loads_and_needs_no_optional_package() -> None:
    done = subprocess.run([sys.executable, "-c", BODY], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    *ids, tried = done.stdout.splitlines()
    assert {"grind/PowerLimited-v0", "grind/Oracle6-v0"} <= set(ids)
    assert tried == "[]"
