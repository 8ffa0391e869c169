"""What the paper reports (Ye et al., IROS 2018, tables I and II): mean actions of successes, success (%)."""

from __future__ import annotations

# (steps, success); steps are None where no search succeeded. What is missing the paper did not run.
TABLE_1: dict[str, dict[str, tuple[float | None, float]]] = {
    "one_object": {
        "random": (2050.3, 60.0),
        "reward_1": (2880.2, 50.0),
        "reward_2": (None, 0.0),
        "record_high": (1957.6, 80.0),
        "record_low": (52.9, 100.0),
    },
    "four_objects": {"random": (1911.6, 72.5), "record_high": (1643.2, 92.5), "record_low": (30.1, 75.0)},
    "sixteen_objects": {"random": (2057.6, 84.3), "record_high": (1430.7, 87.5), "record_low": (593.0, 75.0)},
    "conference_room": {"random": (820.9, 99.0), "record_high": (176.8, 100.0), "record_low": (63.3, 100.0)},
}

TABLE_2: dict[str, dict[str, tuple[float | None, float]]] = {
    "bread": {"record_high": (2566.1, 80.0), "record_low": (52.9, 100.0)},
    "mug": {"record_high": (1426.8, 100.0), "record_low": (36.8, 100.0)},
    "plate": {"record_high": (1114.5, 100.0), "record_low": (None, 0.0)},
    "apple": {"record_high": (2366.6, 90.0), "record_low": (30.8, 100.0)},
}
