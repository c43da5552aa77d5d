"""The version of the tasks; results, parameters and agents of another version are refused.

Ids stay `-v0` until 1.0. Tables of results, reference scores, tuned parameters and trained agents carry the number.
"""

from grind_env.message_text import quoted

TASK_VERSION = 4

#: description of each version, the latest last
HISTORY = {
    1: "the first tasks: D in equal bins over all of its component, constant readings and the true wheel diameter in"
    " the observation, wear that could cost more than the wheel",
    2: "a process model held to measured data, and prices tuned on it; D = 0 up to 1/3; observations without constants,"
    " the hidden entries last, the diameter by the shop's book; no wear beyond what is left of the wheel",
    3: "a process model of the third version; noise from a counter-based generator, drawn block by block; gauging"
    " between two blocks on a part takes a time; dressers, a slow table in Slot and limits of Ra by the model",
    4: "process version 4: the part is a slab on a chuck, and strokes use the true table speed",
}


def of_version(found: object) -> str:
    """Return the text of a message about a file of another task version; None counts as version 1."""
    return f"of task version {1 if found is None else quoted(found)}, and the tasks are now of version {TASK_VERSION}"
