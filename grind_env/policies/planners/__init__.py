"""Strong references: policies that know more than a machine measures; the exact optimum of a small task is a bound."""
