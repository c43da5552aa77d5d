"""Words that are searched on the model, and judged on another machine."""

import pytest

from grind_env import examples
from grind_env.machine.grind import grind_file
from grind_env.render.tables import as_data
from grind_env.shop.calls import optimise
from grind_env.shop.optimise import table

pytestmark = pytest.mark.usefixtures("few_lots", "coarse_speeds")

PLATE = examples.path("plate_g82.nc")
PLANT = "held-out:3"
WISHES = {"vary": ["E"], "parts": 2, "bounds": {"E": (9000, 11000)}, "budget": 60.0}


@pytest.mark.nightly
def test_words_are_searched_on_the_model_and_judged_on_the_machine() -> None:
    on_model, on_plant = optimise(PLATE, **WISHES), optimise(PLATE, **WISHES, plant=PLANT)
    assert (on_model.plant, on_plant.plant) == ("", PLANT)
    assert [word.after for word in on_model.words] == [word.after for word in on_plant.words]
    assert on_model.cheapest == on_plant.cheapest
    assert on_model.quantity("cost").before != on_plant.quantity("cost").before
    for found, plant in ((on_model, None), (on_plant, PLANT)):
        record = grind_file(PLATE, plant=plant)
        cost = as_data(record, record.job, "")["cost"] / len(record.parts)
        assert found.quantity("cost").expected[0] == pytest.approx(cost, rel=1e-6)
    assert all(each.price is None for each in on_plant.limits)
    assert f"judged on {PLANT}" in table.heading(on_plant) and table.as_data(on_plant)["plant"] == PLANT
    assert "plant" not in table.as_data(on_model) and "judged on" not in table.heading(on_model)
