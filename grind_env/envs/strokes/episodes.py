"""The state of episodes of `grind/Stroke-v0`."""

from dataclasses import dataclass

from grind_env.arrays import Numbers, Table
from grind_env.envs.episodes import NOISE, Episodes, EpisodesT


@dataclass(slots=True)
class StrokeEpisodes(Episodes):
    """The state of N episodes; the arrays are those of `step.StrokeArrays`, `block` counts finished parts."""

    rows: Table
    strokes: Table
    paces: Table
    plunges: Table
    parameters: Table
    noise: Table

    def hide_noise(self) -> None:
        """As `Episodes.hide_noise`; that of the strokes is apart, and the part in work has a row of its own."""
        Episodes.hide_noise(self)
        self.noise[:] = self.rows[:, NOISE] = 0.0

    def window(self: EpisodesT, tape: Table, owner: Numbers, first: int, blocks: int) -> EpisodesT:
        """The branches as they are: their tapes have a row a part, and each of them is somewhere on one."""
        return self
