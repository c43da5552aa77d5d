"""Columns of the tables of `Episodes` that policies read and simulations write."""

from grind_env.envs.block_kind_rows import KindRow
from grind_env.envs.cost import Outcome
from grind_env.envs.noise_tape import TapeRow
from grind_env.envs.past_readings import History
from grind_env.process.stroke_types import WheelState

STOCK, GAUGED = TapeRow._fields.index("stock"), TapeRow._fields.index("gauged")
ENDS_PART, SCRAP = KindRow._fields.index("ends_part"), KindRow._fields.index("scrap")
NOMINAL_STOCK = KindRow._fields.index("stock")
NEW_LOT, PRESSURE = TapeRow._fields.index("new_lot"), TapeRow._fields.index("pm")
PART_ROUGHNESS = TapeRow._fields.index("part_ra")
ROUGHNESS, SPARE_ROUGHNESS = TapeRow._fields.index("ra_scale"), TapeRow._fields.index("spare_ra_scale")
DUE, WORK = TapeRow._fields.index("due"), TapeRow._fields.index("work")
#: columns that the list of the blocks to grind shows in advance
LISTED = [TapeRow._fields.index(name) for name in ("kind", "material", "work", "is_due")]
#: columns of the factors of a wheel: of the first wheel, and of a wheel after a change
OF_WHEEL = [tuple(TapeRow._fields.index(name) for name in (old, f"spare_{old}")) for old in ("kA", "ra_scale")]
CHANGES, CLOCK, SURVIVAL = (History._fields.index(name) for name in ("wheel_changes", "clock", "survival"))
COST, SECONDS = Outcome._fields.index("cost"), Outcome._fields.index("seconds")
AREA, LOADING, VOLUME = (WheelState._fields.index(name) for name in ("A", "lam", "V"))
DIAMETER = WheelState._fields.index("ds")
