"""Small things to be found: OBJECTS maps a category to its generator.

A generator takes a `numpy.random.Generator`, which decides colours and proportions, and returns pieces standing on
z = 0 at their origin, in metres.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from active_perceiver.rooms.objects import cookware, decor, food, packages, tableware
from active_perceiver.rooms.pieces import Pieces

OBJECTS: dict[str, Callable[[np.random.Generator], Pieces]] = {
    "apple": food.apple,
    "banana": food.banana,
    "book": packages.book,
    "bottle": packages.bottle,
    "bowl": tableware.bowl,
    "bread": food.bread,
    "can": packages.can,
    "cereal": packages.cereal,
    "cutting_board": decor.cutting_board,
    "green_apple": food.green_apple,
    "herb_pot": decor.herb_pot,
    "jar": tableware.jar,
    "kettle": cookware.kettle,
    "knife_block": cookware.knife_block,
    "lemon": food.lemon,
    "milk": packages.milk,
    "mug": tableware.mug,
    "orange": food.orange,
    "pan": cookware.pan,
    "paper_roll": decor.paper_roll,
    "pepper_mill": decor.pepper_mill,
    "plate": tableware.plate,
    "pot": cookware.pot,
    "soap": packages.soap,
    "spray_bottle": packages.spray_bottle,
    "teapot": tableware.teapot,
    "toaster": cookware.toaster,
    "utensil_crock": decor.utensil_crock,
    "vase": decor.vase,
}

__all__ = ["OBJECTS"]
