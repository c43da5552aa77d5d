"""PPO with a GRU in one file, to be read from top to bottom: plain PyTorch on the native vector environment.

`grind train` calls this module, then writes and evaluates the agent.

The style is CleanRL's (Huang et al., J. Mach. Learn. Res. 23, 2022, 274). Comments give the source of each choice: PPO
is Schulman et al., arXiv:1707.06347; "37" is Huang et al., The 37 Implementation Details of PPO, ICLR blog 2022;
"matters" is Andrychowicz et al., arXiv:2006.05990; "tried" is a choice of this file, with its gain on PowerLimited in
points of the score, on 256 validation episodes, paired, one training seed.
"""

from collections.abc import Callable
from dataclasses import astuple, dataclass, replace
from itertools import pairwise
from typing import Literal

import numpy as np
import torch
from gymnasium import spaces
from torch import Tensor, nn

from grind_env.array_types import Array
from grind_env.envs.cost import Outcome
from grind_env.envs.learning_scales import ease_rewards, fit_standard, lateness
from grind_env.envs.observation_memory import Flags
from grind_env.envs.simulation import Simulation
from grind_env.envs.space_metadata import CLIP, Standard
from grind_env.envs.vector_env import GrindVectorEnv
from grind_env.kernel.random import WORD
from grind_env.plants.family import SEED
from grind_env.plants.plant_names import Plants
from grind_env.policies.evaluation import nobody
from grind_env.policies.learned.agent_spaces import GRID, LearnerForm, LearnerView, MemoryKind
from grind_env.policies.learned.network import Actor, LearnedPolicy, Network
from grind_env.policies.nominal_model import model_of
from grind_env.policies.problem_lookup import Problem
from grind_env.training.checkpoint import Checkpoint

Memory = Literal["none", "stack", "gru", "belief", "state"]
#: memory in the features of each agent; `state` sees the full observation, all others start from the measured one
SEEN: dict[Memory, MemoryKind] = {"none": "none", "stack": "stack", "gru": "none", "belief": "belief", "state": "none"}
#: first training seed, distance between the seeds of two trainings, and last training before the validation seeds
FIRST_SEED, SEED_STRIDE, LAST_SEED = 100_000, 1_000, 398
KIND = "ppo_"  #: prefix of the memory in the name of an agent
LEAST_DEVIATION = 1e-2
DRAWN = 256  #: number of machines that are drawn to standardise the constants of machines
FINISHED, GOOD = Outcome._fields.index("finished"), Outcome._fields.index("good")


@dataclass(frozen=True, slots=True, kw_only=True)
class Settings:
    """Settings of a training."""

    memory: Memory = "gru"
    steps: int = 1_000_000
    envs: int = 128
    #: steps of an environment between two updates: one episode of most tasks, so that gradients cover all of it
    rollout: int = 60
    minibatches: int = 8
    epochs: int = 4
    learning_rate: float = 2e-3  #: learning rate at the start: a factor on each step of the optimiser
    gamma: float = 0.97  #: discount factor: a reward counts less by this factor with each step into the future
    #: lambda of generalised advantages: a factor on the errors of the values with each step into the future
    gae_lambda: float = 0.9
    clip: float = 0.2  #: largest distance from 1 at which a ratio of new to old likelihood counts
    entropy: float = 0.003  #: factor on the entropy; like the learning rate, this factor falls linearly to 0
    value: float = 0.5  #: factor on the error of the critic
    guess: float = 0.5  #: factor on the error of the guess of the hidden values
    alike: float = 1.0  #: number of levels of E over which the logit of one level spreads, as a standard deviation
    norm: float = 0.5  #: largest norm of the gradient; a longer gradient is scaled down by a factor
    units: int = 64
    hidden: tuple[int, ...] = (64, 64)
    split: str = "inner"
    #: number of episodes on a machine; the GRU remembers all of them (RL^2: Duan et al., arXiv:1611.02779)
    shifts: int = 1
    #: number of first updates that train only the critic, which is new when training starts with a trained actor
    critic_first: int = 0
    budget: float | None = None  #: largest share of scrap parts, which a multiplier enforces; None for no limit
    #: largest growth of the multiplier (a factor on scrap in rewards) in an update: for scrap at twice the budget
    multiplier_rate: float = 0.5

    @property
    def signals(self) -> int:
        """Return the number of signals that the critic predicts: reward and, with a budget, scrap."""
        return 1 if self.budget is None else 2


class Agent(nn.Module):
    """An actor and a critic, and for the memory `gru` a GRU before them with a guess of the hidden values.

    Args:
        entries: number of features.
        hidden: number of hidden values after the features, which only the simulator knows.
        choices: number of values of E and of D.
        settings: settings of the training.
    """

    def __init__(self, entries: int, hidden: int, choices: list[int], settings: Settings) -> None:
        super().__init__()
        self.entries, self.choices, width = entries, choices, entries
        self.gru = nn.GRU(entries, settings.units) if settings.memory == "gru" else None
        if self.gru is not None:
            for name, values in self.gru.named_parameters():
                # 37: orthogonal weights, no bias; gate by gate, or few entries would hardly move the gates
                for gate in values.data.chunk(3):
                    nn.init.orthogonal_(gate, 2**0.5) if "weight" in name else nn.init.zeros_(gate)
            # the features also bypass the GRU: choices that need no memory are learned as without a GRU
            width = settings.units + entries
            # tried, +2.7: the GRU also learns to guess the hidden values (Mirowski et al., arXiv:1611.03673)
            self.guess = nn.Linear(settings.units, hidden)
        # matters: actor and critic share no layer, and the last layer of the actor begins near 0
        self.actor = layers((width, *settings.hidden, sum(choices)), 0.01)
        self.critic = layers((width, *settings.hidden, settings.signals), 1.0)
        # tried, +3.1: neighbouring levels of E have similar effects, so each logit spreads over its neighbours
        away = torch.arange(choices[0]).float() - torch.arange(choices[0])[:, None]
        near = (-0.5 * (away / settings.alike).square()).exp()
        self.blur = torch.eye(sum(choices))
        self.blur[: choices[0], : choices[0]] = near / near.norm(dim=0)

    def forward(self, seen: Tensor, state: Tensor, begun: Tensor) -> tuple[list[Tensor], Tensor, Tensor, Tensor]:
        """Return log-probabilities of every E and D, values, squared error of the guess, and the next state of the GRU.

        Args:
            seen: features and hidden values, shape (steps, N, entries + hidden).
            state: state of the GRU before these steps, shape (1, N, units).
            begun: 1 where the first episode on a machine begins, shape (steps, N).
        """
        features, hidden = seen[..., : self.entries], seen[..., self.entries :]
        wrong = torch.zeros(())
        if self.gru is not None:
            # 37: the GRU forgets the machine before; between two new machines the GRU runs in one call
            cuts = [0, *(k for k in range(1, len(begun)) if begun[k].any()), len(begun)]
            outputs = []
            for first, stop in pairwise(cuts):
                out, state = self.gru(features[first:stop], state * (1.0 - begun[first])[:, None])
                outputs.append(out)
            remembered = torch.cat(outputs)
            wrong = (self.guess(remembered) - hidden).square().mean()
            features = torch.cat([remembered, features], -1)
        logits = (self.actor(features) @ self.blur).split(self.choices, -1)
        # only the actor and the guess train the GRU, not the critic
        return [each.log_softmax(-1) for each in logits], self.critic(features.detach()), wrong, state


def layers(widths: tuple[int, ...], gain: float) -> nn.Sequential:
    """Return linear layers with tanh between them; 37, matters: orthogonal weights, `gain` on the last layer."""
    made: list[nn.Module] = []
    for k, (inputs, outputs) in enumerate(pairwise(widths)):
        layer = nn.Linear(inputs, outputs)
        nn.init.orthogonal_(layer.weight, gain if k == len(widths) - 2 else 2**0.5)
        nn.init.zeros_(layer.bias)
        made += [layer, nn.Tanh()]
    return nn.Sequential(*made[:-1])


def likelihood(logs: list[Tensor], actions: Tensor) -> Tensor:
    """Return the log-probability of actions of shape (..., 2)."""
    taken = [log.gather(-1, actions[..., k : k + 1]) for k, log in enumerate(logs)]
    return torch.cat(taken, -1).sum(-1)


class ReturnScale:
    """Running mean and deviation of the returns, shape (signals,)."""

    def __init__(self, signals: int) -> None:
        self.count, self.mean, self.square = 0, torch.zeros(signals), torch.zeros(signals)

    def take(self, returns: Tensor) -> None:
        """Add returns of shape (N, signals) to the statistics: Chan, Golub, LeVeque, Am. Stat. 37 (1983) 242."""
        count, shift = self.count + len(returns), returns.mean(0) - self.mean
        self.square += returns.var(0, correction=0) * len(returns) + shift**2 * self.count * len(returns) / count
        self.mean = self.mean + shift * len(returns) / count
        self.count = count

    @property
    def deviation(self) -> Tensor:
        """Return the standard deviation of each signal."""
        return (self.square / max(self.count, 1)).sqrt().clamp(min=LEAST_DEVIATION)


class Seen:
    """Observations of N episodes: the features of a memory, followed by privileged values of the simulator.

    The class fulfils the protocols `EpisodeMemory` and `MemoryForm`.

    Args:
        simulation: simulation as the agent sees it.
        memory: memory of the agent.
    """

    def __init__(self, simulation: Simulation, memory: Memory) -> None:
        self.measured, self.view = len(simulation.entries), LearnerView(simulation, SEEN[memory])
        self.space, self.begin, self.restart = self.view.observation_space, self.view.begin, self.view.restart

    def memory(self, simulation: Simulation | None, observation_space: object, action_space: object) -> "Seen":
        """Return this object, which is its own memory."""
        return self

    def take(self, observations: Array, actions: Array | None, mask: Flags) -> Array:
        """Return features and hidden values of full observations; `mask`, shape (N,), selects the episodes."""
        features = self.view.features(observations[:, : self.measured], mask)
        return np.concatenate([features, observations[:, self.measured :]], axis=1)


class Machines:
    """Machines of the environments; each machine stays for `shifts` episodes.

    With one shift, the environments draw their machines themselves.

    Args:
        envs: the environments.
        shifts: number of episodes on a machine.
        seed: seed from which machines are drawn.
    """

    def __init__(self, envs: GrindVectorEnv, shifts: int, seed: int) -> None:
        self.envs, self.shifts, self.rng = envs, shifts, np.random.default_rng(seed)
        # environments start in different shifts, so that every shift occurs at any time
        self.shift, self.hidden = np.arange(envs.num_envs) % shifts, torch.zeros(envs.num_envs, 0)
        self.plants = envs.simulation.plants if shifts > 1 else None
        if self.plants is not None:
            names = self.plants.first.remembers._fields
            drawn = np.array([self.plants.seeded(k).first.own for k in range(DRAWN)])
            self.differ = (drawn.std(axis=0) > 0.0) & [not name.endswith(SEED) for name in names]
            self.mean, self.deviation = drawn[:, self.differ].mean(axis=0), drawn[:, self.differ].std(axis=0)
            self.first = [self._drawn() for _ in range(envs.num_envs)]
            envs.given = [replace(each, plant=first) for each, first in zip(envs.given, self.first, strict=True)]
            self._tell()

    def change(self, over: Flags) -> Flags:
        """Set the machine of the next episode for environments in `over`, shape (N,): the present or a new machine.

        Returns:
            Mask of the environments with a new machine, shape (N,).
        """
        self.shift[over] = (self.shift[over] + 1) % self.shifts
        if self.plants is not None:
            for i in np.flatnonzero(over).tolist():
                if self.shift[i] == 0:
                    self.first[i] = plants = self._drawn()
                else:
                    left = self.envs.episodes.extra_state(i)
                    plants = replace(self.first[i], first=self.first[i].first.after(left, self._number()))
                self.envs.given[i] = replace(self.envs.given[i], plant=plants)
            self._tell()
        another: Flags = over & (self.shift == 0)
        return another

    def _number(self) -> int:
        return int(self.rng.integers(WORD))

    def _drawn(self) -> Plants:
        assert self.plants is not None
        return self.plants.seeded(self._number())

    def _tell(self) -> None:
        """Set the standardised constants of the machines, which the agent learns to guess."""
        own = np.array([each.first.own for each in self.first])[:, self.differ]
        self.hidden = torch.as_tensor((own - self.mean) / self.deviation, dtype=torch.float32)


class TrainingEnvs:
    """Environments of a training, as the agent sees them.

    Args:
        problem: problem on the model or on drawn machines.
        settings: settings of the training.
        seed: seed of the training.
    """

    def __init__(self, problem: Problem, settings: Settings, seed: int) -> None:
        self.envs = problem.make_vec(settings.envs, observation="full", action=GRID, autoreset_mode="Disabled")
        self.memory, self.everyone = Seen(model_of(problem), settings.memory), np.ones(settings.envs, bool)
        # matters: all is standardised, by observations of good play: readings of spoilt parts are many times as large
        self.standard = fit_standard(self.envs.simulation, self.envs.codec, [self.memory])
        first = FIRST_SEED + SEED_STRIDE * seed
        self.machines = Machines(self.envs, settings.shifts, first)
        observations, _ = self.envs.reset(seed=first, options={"split": settings.split})
        self.memory.begin(settings.envs)
        self.late = lateness(self.envs.simulation, observations)
        self.seen = self._standardised(self.memory.take(observations, None, self.everyone))
        self.begun = torch.ones(settings.envs)

    @property
    def entries(self) -> int:
        """Return the number of features."""
        return self.memory.space.shape[0]

    @property
    def scale(self) -> Standard:
        """Return mean and standard deviation of the features."""
        return Standard(*(values[: self.entries] for values in astuple(self.standard)))

    def step(self, actions: np.ndarray) -> tuple[np.ndarray, float, np.ndarray, Tensor]:
        """Grind one block in every environment.

        Returns:
            Rewards and scrap, shape (N, 2); number of finished parts; mask of the episodes that were truncated on the
            last shift of a machine, shape (N,); observations before new episodes begin.
        """
        last, rewards, terminated, truncated, _ = self.envs.step(actions)
        over, observations, begun = terminated | truncated, last, np.zeros(len(last), bool)
        seen = shows = self.memory.take(last, None, self.everyone)
        if over.any():
            begun = self.machines.change(over)
            observations, _ = self.envs.reset(options={"reset_mask": over})
            self.memory.restart(over)
            shows = np.where(over[:, None], self.memory.take(observations, None, over), seen)
        self.seen, self.begun = self._standardised(shows), torch.as_tensor(begun, dtype=torch.float32)
        # the probability of scrap, which the simulator knows, tells more about a part than the verdict good or bad
        finished, good = self.envs.last[0][:, [FINISHED, GOOD]].T
        # tried on Rush: lateness is charged as it grows; one large charge is cut, and agents on public machines dawdled
        charged = rewards + self.late - lateness(self.envs.simulation, last)
        self.late = lateness(self.envs.simulation, observations)
        # rewards are raised by one: the best fixed plan earns about 0, and scrap does not dominate an update
        earned = np.stack([ease_rewards(charged), finished - good], axis=1)
        return earned, float(finished.sum()), truncated & begun, self._standardised(seen)

    def _standardised(self, seen: Array) -> Tensor:
        values = torch.as_tensor((seen - np.array(self.standard.mean)) / self.standard.deviation, dtype=torch.float32)
        # the features are not cut, because their scale is folded into the layer that reads them
        values[:, self.entries :].clamp_(-CLIP, CLIP)
        return torch.cat([values, self.machines.hidden], 1)


class Training:
    """The state of a training between two updates. A training resumed from it gives the same agent, to the bit.

    Args:
        problem: problem as `shown` returns it, on the model or on drawn machines.
        settings: settings of the training.
        seed: seed of weights, choices and episodes; at most `LAST_SEED`, to leave out the validation seeds.
        actor: actor with which the training begins; None for a new one.

    Attributes:
        updates: number of finished updates.
    """

    def __init__(self, problem: Problem, settings: Settings, seed: int, actor: Actor | None) -> None:
        torch.manual_seed(seed)
        self.episodes = TrainingEnvs(problem, settings, seed)
        space, entries = self.episodes.memory.view.action_space, self.episodes.entries
        assert isinstance(space, spaces.MultiDiscrete)
        self.agent = Agent(entries, self.episodes.seen.shape[1] - entries, space.nvec.tolist(), settings)
        if actor is not None:
            take_over(self.agent, actor, self.episodes.scale)
        self.optimiser = torch.optim.Adam(self.agent.parameters(), settings.learning_rate, eps=1e-5)  # 37: eps
        self.state = torch.zeros(1, settings.envs, settings.units)
        self.worth, self.multiplier, self.updates = ReturnScale(settings.signals), 0.0, 0


def train(
    problem: Problem,
    settings: Settings,
    seed: int,
    advance: Callable[[int], object] = nobody,
    checkpoint: Checkpoint | None = None,
    actor: Actor | None = None,
) -> tuple[Agent, Standard]:
    """Return a trained agent, and mean and standard deviation of its features.

    Args:
        problem: problem, as for `Training`.
        settings: settings of the training.
        seed: seed of the training, as for `Training`.
        advance: called with the number of steps since its last call.
        checkpoint: file that is written after each update; if the file exists, its training is resumed.
        actor: actor with which the training begins; None for a new one.
    """
    torch.set_num_threads(1)  # at this size a second thread only costs
    training = Training(problem, settings, seed, actor)
    if checkpoint is not None:
        training = checkpoint.resume(training)
    episodes, agent, optimiser, worth = training.episodes, training.agent, training.optimiser, training.worth
    n, steps, width = settings.envs, settings.rollout, episodes.seen.shape[1]
    state, multiplier = training.state, training.multiplier
    updates = max(settings.steps // (n * steps), 1)
    advance(training.updates * n * steps)
    for update in range(training.updates, updates):
        # 37 and matters: the rate falls linearly to 0
        left = 1.0 - update / updates
        optimiser.param_groups[0]["lr"] = settings.learning_rate * left
        seen, actions = torch.zeros(steps, n, width), torch.zeros(steps, n, 2, dtype=torch.int64)
        chances, begun = torch.zeros(steps, n), torch.zeros(steps + 1, n)
        rewards, values = torch.zeros(steps, n, settings.signals), torch.zeros(steps + 1, n, settings.signals)
        scrap, parts, before = 0.0, 0.0, state
        for k in range(steps + 1):
            begun[k] = episodes.begun
            with torch.no_grad():
                logs, value, _, after = agent(episodes.seen[None], state, begun[k, None])
            values[k] = worth.mean + worth.deviation * value[0]
            if k == steps:
                break
            state, seen[k] = after, episodes.seen
            actions[k] = torch.cat([log[0].exp().multinomial(1) for log in logs], -1)
            chances[k] = likelihood(logs, actions[k][None])[0]
            reward, finished, truncated, last = episodes.step(actions[k].numpy())
            rewards[k] = torch.as_tensor(reward[:, : settings.signals])
            scrap, parts = scrap + reward[:, 1].sum(), parts + finished
            if truncated.any():
                # a time limit is no end: the value stands for the rewards to come (Pardo et al., arXiv:1712.00378)
                with torch.no_grad():
                    rest = worth.mean + worth.deviation * agent(last[None], state, torch.zeros(1, n))[1][0]
                rewards[k] += settings.gamma * rest * torch.as_tensor(truncated)[:, None]
        # generalised advantages (Schulman et al., arXiv:1506.02438)
        goes_on = 1.0 - begun[1:, :, None]
        advantages = torch.zeros_like(rewards)
        ahead = torch.zeros_like(rewards[0])
        for k in reversed(range(steps)):
            error = rewards[k] + settings.gamma * values[k + 1] * goes_on[k] - values[k]
            advantages[k] = ahead = error + settings.gamma * settings.gae_lambda * goes_on[k] * ahead
        returns = advantages + values[:-1]
        # matters: the critic learns returns of mean 0 and deviation 1
        worth.take(returns.flatten(0, 1))
        targets = (returns - worth.mean) / worth.deviation
        gains = advantages[..., 0]
        if settings.budget is not None:
            # the Lagrangian of PPO-Lagrangian (Ray, Achiam, Amodei, Benchmarking Safe Exploration, 2019)
            # the multiplier grows no faster than it can fall: a beginner scraps half of all parts
            excess = min(scrap / max(parts, 1.0) / settings.budget - 1.0, 1.0)
            multiplier = max(multiplier + settings.multiplier_rate * excess, 0.0)
            gains = gains - multiplier * advantages[..., 1]
        for _ in range(settings.epochs):
            # 37: a minibatch has all steps of some environments, because the GRU needs steps in their order
            for index in torch.randperm(n).chunk(settings.minibatches):
                logs, value, wrong, _ = agent(seen[:, index], before[:, index], begun[:-1, index])
                # 37: the advantages of a minibatch have mean 0 and deviation 1
                chosen = gains[:, index]
                chosen = (chosen - chosen.mean()) / (chosen.std() + 1e-8)
                ratio = (likelihood(logs, actions[:, index]) - chances[:, index]).exp()
                clipped = ratio.clamp(1.0 - settings.clip, 1.0 + settings.clip)
                gain = torch.minimum(ratio * chosen, clipped * chosen).mean()
                entropy = -sum((log.exp() * log).sum(-1).mean() for log in logs)
                # matters: no clipping of the value
                miss = (value - targets[:, index]).square().mean()
                acts = gain + settings.entropy * left * entropy if update >= settings.critic_first else 0.0
                loss = settings.value * miss + settings.guess * wrong - acts
                optimiser.zero_grad()
                loss.backward()
                nn.utils.clip_grad_norm_(agent.parameters(), settings.norm)  # 37
                optimiser.step()
        training.state, training.multiplier, training.updates = state, multiplier, update + 1
        if checkpoint is not None:
            checkpoint.write(training)
        advance(n * steps)
    return agent, episodes.scale


def acting_part(agent: Agent, scale: Standard) -> Actor:
    """Return the actor in NumPy; its first layer includes the scaling, its last the spreading over levels of E."""
    acts = {name: each for name, each in agent.state_dict().items() if name.startswith(("actor", "gru"))}
    state = _folded(agent, {name: each.detach().double().numpy() for name, each in acts.items()}, scale, agent.blur)
    network = Network(
        family="gru",
        entries=agent.entries,
        lstm=0 if agent.gru is None else agent.gru.hidden_size,
        hidden=tuple(each.out_features for each in agent.actor if isinstance(each, nn.Linear))[:-1],
        outputs=sum(agent.choices),
        activation="tanh",
    )
    return Actor(network, {name: values.astype(np.float32) for name, values in state.items()})


def take_over(agent: Agent, actor: Actor, scale: Standard) -> None:
    """Load an actor from `acting_part` into an agent; the agent's critic and guess stay as they are."""
    mean, deviation = np.array(scale.mean), np.array(scale.deviation)
    back = Standard(tuple(-mean / deviation), tuple(1.0 / deviation))
    acts = {name: values.astype(np.float64) for name, values in actor.tensors.items()}
    state = _folded(agent, acts, back, agent.blur.double().inverse())
    agent.load_state_dict({name: torch.as_tensor(each).float() for name, each in state.items()}, strict=False)


def _folded(agent: Agent, state: dict[str, Array], scale: Standard, blur: Tensor) -> dict[str, Array]:
    """Return acting layers with `scale` folded into the layers that read features, and `blur` into the last layer."""
    entries, mean, found = len(scale.mean), np.array(scale.mean), dict(state)
    seen = [("actor.0.weight", "actor.0.bias")]
    if agent.gru is not None:
        seen.append(("gru.weight_ih_l0", "gru.bias_ih_l0"))
    for weight, bias in seen:
        # the features are the last inputs of the first layer
        factors = state[weight][:, -entries:] / scale.deviation
        found[bias] = state[bias] - factors @ mean
        found[weight] = np.concatenate([state[weight][:, :-entries], factors], axis=1)
    for part in ("weight", "bias"):
        last = f"actor.{len(agent.actor) - 1}.{part}"
        found[last] = blur.double().numpy().T @ state[last]
    return found


def policy_of(agent: Agent, scale: Standard, problem: Problem, memory: Memory) -> LearnedPolicy:
    """Return a trained agent as a policy that takes its most probable action."""
    policy = LearnedPolicy(acting_part(agent, scale), problem.name, form_of(memory), KIND + memory)
    policy.sees = "state" if memory == "state" else "measurements"
    return policy


def form_of(memory: Memory) -> LearnerForm:
    """Return the observations and actions of an agent with this memory."""
    return LearnerForm(SEEN[memory])


def shown(problem: Problem, memory: Memory) -> Problem:
    """Return the problem with the observations of an agent with this memory."""
    full = (("observation", "full"),) if memory == "state" else ()
    return replace(problem, arguments=(*problem.arguments, *full))
