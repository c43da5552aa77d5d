"""Check an install without torch and Stable-Baselines3: step the environments, evaluate and play policies.

`make core` runs this script outside the checkout, with the Python of an environment that has only this install.
"""

import importlib.util
import subprocess
import sys
from pathlib import Path

import gymnasium as gym
from gymnasium.vector import AutoresetMode

import grind_env

SHIPPED = Path(grind_env.__file__).parent / "policies" / "shipped"
HEAVY = ("torch", "stable_baselines3", "matplotlib", "pandas")


def main() -> str | None:
    """Return what is wrong, or print one line and return None."""
    present = [name for name in HEAVY if importlib.util.find_spec(name) is not None]
    if present:
        return f"not a core install: {', '.join(present)} can be imported"
    if Path(grind_env.__file__).parents[1] == Path(__file__).resolve().parents[1]:
        return f"not the installed package: {grind_env.__file__} belongs to the checkout"

    ids = [name for name in gym.registry if name.startswith("grind/")]
    if not ids:
        return "importing grind_env registered no environment"
    for name in ids:
        env = gym.make(name)
        env.reset(seed=0)
        env.step(env.action_space.sample())
        for mode in AutoresetMode:
            vector = gym.make_vec(name, num_envs=4, autoreset_mode=mode)
            vector.reset(seed=0)
            vector.step(vector.action_space.sample())
    rule = grind_env.evaluate("adaptive_rule", "grind/PowerLimited-v0", episodes=8)
    agent = grind_env.evaluate("plain_gru", "power_limited", episodes=8)
    if not rule.score or not agent.score or agent.score.value < rule.score.value:
        return f"the bundled agent is no better than a rule: {agent}, {rule}"
    task = Path("shop.toml")
    task.write_text('base = "power_limited"\nblocks = 6\n', encoding="utf-8")
    command = [sys.executable, "-m", "grind_env", "play", "--no-window", "--policy", "E12000D1", "--task", task]
    played = subprocess.run(command, capture_output=True, text=True, check=False)
    if played.returncode != 0 or "good parts of 6" not in played.stdout:
        return f"playing a task file failed: {played.stderr or played.stdout}"
    shipped = [sys.executable, "-m", "grind_env", "play", "--output", "played.nc"]
    if (
        subprocess.run(shipped, capture_output=True, check=False).returncode != 0
        or "G82" not in Path("played.nc").read_text()
    ):
        return "playing the bundled agent failed"
    grind = [sys.executable, "-m", "grind_env"]
    policy = ["--policy", str(SHIPPED / "plain_gru" / "rush.safetensors")]
    submitted = [*grind, "evaluate", *policy, "--env", "rush", "--submit", "row.json"]
    subprocess.run(submitted, capture_output=True, check=False)
    verified = subprocess.run(
        [*grind, "verify", "row.json", *policy, "--seed", "31415926535897932384"], capture_output=True, check=False
    )
    if verified.returncode != 0:
        return f"verifying a row failed: {verified.stdout.decode()} {verified.stderr.decode()}"
    print(f"OK: core install of grind_env {grind_env.__version__}, {len(ids)} environments stepped, {agent}")
    return None


if __name__ == "__main__":
    sys.exit(main())
