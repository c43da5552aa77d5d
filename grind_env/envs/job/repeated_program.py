"""The text of a user's program: repeated for many parts, with the words that an agent has chosen."""

import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from decimal import Decimal
from functools import partial
from itertools import repeat
from pathlib import Path
from typing import NamedTuple, TypeAlias

from grind_env.control import Control, ControlError, CycleAhead, CycleStart, Programs, execute, read
from grind_env.control.block_words import Block, read_block
from grind_env.control.cycle_planning import ModalWords
from grind_env.control.macro_statements import Goto, label_of, with_label
from grind_env.control.macro_variables import LOCALS
from grind_env.control.motion_paths import INTEGRANDS
from grind_env.control.program_scanner import SourceText, readable
from grind_env.control.word_rewriting import with_words
from grind_env.envs.job.program_outline import INCH, JobProgramError
from grind_env.envs.program_episode import Words

#: blocks between two parts: they load the next part and set the modes in which a program begins (10-23)
LOAD = ("G80", "M00", "G92.1", "G00 G18 G07 G71 G90 G94 G97 G40 G54")

MOST_PARTS = 1000  #: largest number of parts for which a program can be run

MOST_LABELS = 100_000  #: number of possible N numbers, 0 included

_COMMENT = r"\([^()]*\)"
_COMMENTS = re.compile(_COMMENT)
_END = re.compile(rf"({_COMMENT})|[Mm]0*(?:2|30)(?![\d.])")
_TO = r"GOTO[ \t]*\[?[ \t]*"
_GOTO = re.compile(rf"({_COMMENT})|({_TO})[0-9]+", re.IGNORECASE)
_LITERAL = re.compile(rf"{_TO}([0-9]+)[ \t]*\]?[ \t]*$", re.IGNORECASE)
_ASSIGNED = re.compile(r"#[ \t]*([0-9]+)[ \t]*=")
_INDIRECT = re.compile(r"#[ \t]*[\[#]")

_LINE = re.compile(r"[^\r\n]*(?:\r\n|\r|\n|\Z)")


def with_words_chosen(programs: Programs, chosen: Sequence[tuple[Block, Words]]) -> str:
    """Return the text of the main program's file with the chosen words in the blocks that have been run."""
    with programs.main.blocks.text.open() as handle:
        lines = _LINE.findall(readable(handle.read().decode("utf-8-sig", "surrogateescape")))
    changed: dict[tuple[int, int], tuple[str, str]] = {}
    for block, words in chosen:
        source = block.source
        if source.file != programs.name:
            raise JobProgramError(
                f"{source.file}:{source.line}: the cycle block is in another file than {programs.name}; put all "
                "programs into one file to have them with the words chosen"
            )
        text = with_words(block, words).source.text
        if changed.setdefault((source.line, source.column), (source.text, text))[1] != text:
            raise JobProgramError(
                f"{source.file}:{source.line}: the cycle block has run more than once with different words, so that "
                "no single text says both; write its M98 calls and loops out"
            )
    for (line, column), (old, new) in sorted(changed.items(), reverse=True):
        text = lines[line - 1]
        lines[line - 1] = text[: column - 1] + new + text[column - 1 + len(old) :]
    return "".join(lines)


def batch_name(program: Path, parts: int) -> str:
    """Return the name of a batch of a program in tables and folders: `plate_g82_x30`."""
    return f"{program.stem}_x{parts}" if parts > 1 else program.stem


class Batch(NamedTuple):
    """A program that is run for many parts, as one program."""

    programs: Programs
    #: blocks of the original program, by their line in `programs`; empty if both programs are the same
    origins: Mapping[int, SourceText]

    def origin(self, block: Block) -> Block:
        """Return a block as it is in the original program."""
        source = self.origins.get(block.source.line) if block.source.file == self.programs.name else None
        return block if source is None else read_block(source)


#: text of a block of a batch, and its block in the original program; None for an added block
Written: TypeAlias = tuple[str, SourceText | None]


def repeated(programs: Programs, parts: int, variables: Mapping[int, float] = {}) -> Programs:
    """Return a program that is run for many parts; arguments and errors as for `batch_of`."""
    return batch_of(programs, parts, variables).programs


def batch_of(programs: Programs, parts: int, variables: Mapping[int, float] = {}) -> Batch:
    """Return a program for many parts: an M00, at which the operator loads, replaces the end of each run.

    Before each M00 the table is stopped and G92 cancelled, as at the end; G10 values stay. Common variables keep their
    values from run to run; local variables begin each run as the first. Targets of GOTO get new N numbers in every run
    but the last. Cycle blocks that take E from F, or I from the position of the table, get these words, because the end
    of a program forgets E and I of the last cycle and M00 does not.
    """
    if parts == 1:
        return Batch(programs, {})
    for program in [*programs][1:]:
        for block in program.blocks:
            if _ends(block.text):
                raise JobProgramError(
                    f"{block.file}:{block.line}: the program ends in a subprogram and cannot be run for {parts} parts; "
                    "put its M30 into the main program"
                )
    main, texts = [*programs.main.blocks], _with_own_words(programs, variables)
    again = [(text, None) for text in _local_variables(programs, variables)]
    if any(map(jumps, main)):
        runs = _jumping_runs(main, texts, parts)
    else:
        end = next((number for number, source in enumerate(main) if _ends(source.text)), len(main))
        straight = [(_without_end(texts.get(source, source.text)), source) for source in main[: end + 1]]
        runs = repeat([*straight, *((text, None) for text in LOAD)], parts - 1)
    written = [each for run in runs for each in (*run, *again)]
    written += [(texts.get(source, source.text), source) for source in main]
    for program in [*programs][1:]:
        written += [(f"O{program.number}", None), *((source.text, source) for source in program.blocks)]
    text = "\n".join(text for text, _ in written)
    origins = {line: source for line, (_, source) in enumerate(written, 1) if source is not None}
    return Batch(read(text, programs.name, programs.folder), origins)


def _with_own_words(programs: Programs, variables: Mapping[int, float]) -> dict[SourceText, str]:
    """Return new texts, with E and I as words, of cycle blocks that take E from F or I from the position of the table.

    Blocks do so as long as no block before has an E or I. The result is empty if the first cycle block has both words.
    """
    execution = execute(programs, Control(variables=variables, announce_cycles=True, whole_cycles=True))
    found: dict[SourceText, list[dict[str, str]]] = {}
    with suppress(ControlError):  # reported when the batch is executed
        for event in execution:
            if isinstance(event, CycleAhead):
                source = event.block.source
            elif isinstance(event, CycleStart):
                words = _taken_words(event, execution.remembered)
                if not words and not found:
                    return {}
                found.setdefault(source, []).append(words)
    at_end, main, texts = execution.remembered, set(programs.main.blocks), {}
    for source, taken in found.items():
        for words in taken:
            for name in [*words]:
                if (at_end.feed if name == "E" else at_end.secondary) is None:
                    del words[name]  # no run takes this word from the run before
        words = taken[0]
        if any(each != words for each in taken) or (words and source not in main):
            raise JobProgramError(
                f"{source.file}:{source.line}: E or I of the cycle is another one after the first part; write both"
            )
        texts[source] = with_words(read_block(source), words).source.text
    return texts


def _taken_words(start: CycleStart, remembered: ModalWords) -> dict[str, str]:
    """Return the words that a cycle has neither itself nor from an earlier cycle, with their numbers as text."""
    plan, modes, words = start.plan, start.modes, dict[str, float]()
    if remembered.feed is None and modes.feed is not None:
        words["E"] = modes.feed
    if remembered.secondary is None:
        origin = start.origins[modes.work_system][plan.axis]
        words[INTEGRANDS[plan.axis]] = 0.0 if modes.incremental else plan.secondary - origin
    return {name: f"{value / (INCH if modes.inch else 1.0):.4f}".rstrip("0") for name, value in words.items()}


def _jumping_runs(main: Sequence[SourceText], texts: Mapping[SourceText, str], parts: int) -> Iterator[list[Written]]:
    """Return all runs but the last of a program with jumps, each with new N numbers for their targets."""
    labels = {label for source in main if (label := label_of(source.text)) is not None}
    targets = sorted({target for source in main if (target := _target(source, parts)) in labels})
    others = (number for number in range(1, MOST_LABELS) if number not in labels)
    for _ in range(parts - 1):
        own = dict(zip(targets, others, strict=False))
        end = next(others, None)
        if end is None:
            raise JobProgramError(
                f"{main[0].file} cannot be run for {parts} parts: its jumps need more N numbers than there are; choose "
                "fewer parts"
            )
        run = list[Written]()
        for source in main:
            text = texts.get(source, source.text)
            label, target = label_of(text), _target(source, parts)
            if label in own:
                text = with_label(text, own[label])
            if target in own:
                text = _GOTO.sub(partial(_led, own[target]), text)
            run.append((_without_end(text), source))
            if _ends(text):
                run.append((f"{'/' if source.deletable else ''}GOTO {end}", source))
        yield [*run, (f"N{end} {LOAD[0]}", None), *((text, None) for text in LOAD[1:])]


def _led(number: int, match: re.Match[str]) -> str:
    """Return a GOTO with another target number; a comment stays as it is."""
    return match[1] or f"{match[2]}{number}"


def _target(source: SourceText, parts: int) -> int | None:
    """Return the N number to which a block jumps; None if it does not jump."""
    if not jumps(source):
        return None
    match = _LITERAL.search(_COMMENTS.sub("", source.text))
    if match is None:
        raise JobProgramError(
            f"{source.file}:{source.line}: GOTO leads to an N number that is worked out, so that the program cannot be "
            f"run for {parts} parts; write the number there"
        )
    return int(match[1])


def _local_variables(programs: Programs, variables: Mapping[int, float]) -> Iterator[str]:
    """Yield assignments that restore the local variables of the first run: the end of a program clears them (20-13)."""
    texts = [_COMMENTS.sub("", source.text) for program in programs for source in program.blocks]
    assigned = {int(number) for text in texts for number in _ASSIGNED.findall(text)}
    if any(_INDIRECT.search(text) for text in texts):
        assigned |= set(LOCALS)
    for number in sorted(assigned & set(LOCALS)):
        yield f"#{number}={f'{Decimal(repr(float(variables[number]))):f}' if number in variables else '#0'}"


def jumps(source: SourceText) -> bool:
    """Return whether a block jumps by GOTO."""
    try:
        return isinstance(read_block(source).statement, Goto)
    except ControlError:  # the execution refuses the block
        return False


def _ends(text: str) -> bool:
    """Return whether a block ends its program and all callers."""
    return any(match[1] is None for match in _END.finditer(text))


def _without_end(text: str) -> str:
    """Return a block without the word that ends the program."""
    return _END.sub(lambda match: match[1] or "", text)
