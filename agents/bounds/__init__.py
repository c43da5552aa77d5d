"""Upper bounds and strong references: policies that know more than a machine measures."""
