"""What is said where one deep pass at a slow feed is too much."""

from dataclasses import replace

from grind_env.render.reasons import reason
from tests.machine.harness import CATALOGUE, HEAD, job, run


def test_what_is_too_much_is_said_of_its_F() -> None:
    machine = replace(CATALOGUE.machine("default"), power_limit=2000.0)
    shop = job(stock=0.5, tolerance=20.0, roughness_limit=0.1, setup={"machine": machine})
    record = run(f"{HEAD}G01 Y-0.5 F500.\nX230. F600.\nG00 Y20.\nM30\n", shop)
    said = {cause: reason(cause, [1], record, shop) for cause in ("power", "rise", "roughness", "size")}
    assert said["power"].startswith("line 4: ") and said["power"].endswith("; go less deep or lower F")
    assert said["rise"].endswith("; go less deep or lower F, or dress before")
    assert said["roughness"].endswith("; dress finer, lower F, or add strokes at full depth")
    assert said["size"].endswith("; add strokes at full depth, or end with less deep ones")
