"""Jobs written as text and read again."""

from dataclasses import fields, replace
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

import grind_env
from grind_env.machine.job import Diamond, Job, JobError, PartConditions, Stage
from grind_env.machine.job.job_file import load_job
from grind_env.machine.job.job_writer import job_text
from grind_env.process.catalogue import load_catalogue
from tests.examples import examples

EXAMPLES = Path(grind_env.__file__).parent / "examples"
JOB = load_job(EXAMPLES / "plate_g82.toml")
MATERIALS = load_catalogue().materials

lengths = st.floats(1.0, 500.0)
factors = st.dictionaries(st.sampled_from(["kA", "pm", "Gref"]), st.floats(0.01, 100.0), max_size=3)
stages = st.lists(st.builds(Stage, stock=st.just(0.1), tolerance=st.floats(0.0, 1000.0)), max_size=2).map(tuple)
kinds = st.builds(
    lambda material, length, limit, stages: replace(
        JOB.part, material=material, length=length, roughness_limit=limit, stages=stages
    ),
    st.sampled_from(list(MATERIALS.values())),
    lengths,
    st.floats(0.0, 50.0),
    stages,
)
conditions = st.builds(
    PartConditions,
    part=st.none() | kinds,
    stock=st.none() | st.floats(0.001, 10.0),
    factors=factors,
    new_wheel_factors=st.none() | factors.filter(bool),
)
jobs = st.builds(
    lambda part, load, diamond, parts, friction, growth: replace(
        JOB,
        part=part,
        times=replace(JOB.times, load=load),
        diamond=diamond,
        parts=parts,
        setup=replace(JOB.setup, wheel=replace(JOB.setup.wheel, friction=friction)),
        lots=replace(JOB.lots, growth=growth),
    ),
    kinds,
    st.floats(0.0, 1000.0),
    st.none() | st.builds(Diamond, x=lengths, y=lengths, z=lengths),
    st.lists(conditions, max_size=3).map(tuple),
    st.floats(0.1, 0.9),
    st.floats(0.0, 2.0),
)


def read_again(job: Job, folder: Path) -> Job:
    path = folder / "job.toml"
    path.write_text(job_text(job), encoding="utf-8")
    return load_job(path)


@examples(40)
@given(jobs)
def test_a_job_read_again_is_the_same(tmp_path_factory: pytest.TempPathFactory, job: Job) -> None:
    # a part equal to the part of the job is not written
    plain = tuple(replace(each, part=None) if each.part == job.part else each for each in job.parts)
    assert read_again(job, tmp_path_factory.mktemp("job")) == replace(job, parts=plain)


def test_every_value_of_the_setup_may_stand_in_a_job_file(tmp_path: Path) -> None:
    values = {
        "wheel_speed": 25.0,
        "constant_surface_speed": True,
        "spindle": "always on",
        "coolant": "always on",
        "dresser_infeed": 0.03,
        "grooving_wheel": True,
    }
    others = {field.name for field in fields(JOB.setup)} - {"wheel", "dresser", "fluid", "machine"}
    assert set(values) == others
    job = replace(JOB, setup=replace(JOB.setup, **values))
    assert read_again(job, tmp_path) == job


@pytest.mark.parametrize(
    ("tables", "said"),
    [
        ("[parts]\n", "parts is"),
        ("[[parts]]\nstok = 1\n", "part 1: there is no key parts.stok"),
        ("[[parts]]\n[[parts]]\nfactors = { kA = 'x' }\n", "part 2: parts.factors"),
        ("[[parts]]\nstock = 'x'\n", "part 1: parts.stock is 'x', but must be a number from"),
        ("[[parts]]\nfactors = { kZ = 1.0 }\n", "part 1: there is no stroke parameter"),
        ("[[parts]]\npart = { material = 'cheese' }\n", "cheese"),
        ("[[parts]]\npart = { length = -1 }\n", "part.length"),
        ("[catalogue.wheel.mine]\nbase = 'none'\n", "catalogue: wheel 'mine'"),
    ],
)
def test_mistakes_in_tables_of_a_job_are_reported(tables: str, said: str, tmp_path: Path) -> None:
    path = tmp_path / "job.toml"
    path.write_text((EXAMPLES / "rail_g83.toml").read_text() + tables)
    with pytest.raises(JobError, match=said.replace("[", r"\[")):
        load_job(path)
