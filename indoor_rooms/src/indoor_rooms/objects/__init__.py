"""Small things to be found: OBJECTS maps a category to its generator.

A generator takes a `numpy.random.Generator`, which decides colours and proportions, and returns pieces standing on
z = 0 at their origin, in metres.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from indoor_rooms.geometry.pieces import Pieces
from indoor_rooms.objects import (
    carried,
    clocks,
    cookware,
    decor,
    electronics,
    flowers,
    food,
    lamps,
    living,
    media,
    packages,
    paper,
    plants,
    stationery,
    tableware,
    toys,
)

OBJECTS: dict[str, Callable[[np.random.Generator], Pieces]] = {
    "apple": food.apple,
    "bag": carried.bag,
    "ball": toys.ball,
    "banana": food.banana,
    "basket": living.basket,
    "binder": paper.binder,
    "book": paper.book,
    "book_stack": paper.book_stack,
    "bottle": packages.bottle,
    "bowl": tableware.bowl,
    "bread": food.bread,
    "calculator": electronics.calculator,
    "camera": media.camera,
    "can": packages.can,
    "candle": living.candle,
    "cereal": packages.cereal,
    "clock": clocks.clock,
    "cushion": living.cushion,
    "cutting_board": decor.cutting_board,
    "game_controller": electronics.game_controller,
    "globe": toys.globe,
    "green_apple": food.green_apple,
    "headphones": media.headphones,
    "herb_pot": decor.herb_pot,
    "house_plant": plants.house_plant,
    "jar": tableware.jar,
    "kettle": cookware.kettle,
    "knife_block": cookware.knife_block,
    "lamp": lamps.lamp,
    "laptop": electronics.laptop,
    "lemon": food.lemon,
    "milk": packages.milk,
    "mug": tableware.mug,
    "notebook": paper.notebook,
    "orange": food.orange,
    "pan": cookware.pan,
    "paper_roll": decor.paper_roll,
    "pen_cup": stationery.pen_cup,
    "pepper_mill": decor.pepper_mill,
    "phone": electronics.phone,
    "photo_frame": living.photo_frame,
    "plate": tableware.plate,
    "pot": cookware.pot,
    "radio": media.radio,
    "remote_control": electronics.remote_control,
    "scissors": stationery.scissors,
    "soap": packages.soap,
    "spray_bottle": packages.spray_bottle,
    "stapler": stationery.stapler,
    "tape_dispenser": stationery.tape_dispenser,
    "teapot": tableware.teapot,
    "teddy_bear": toys.teddy_bear,
    "tissue_box": stationery.tissue_box,
    "toaster": cookware.toaster,
    "utensil_crock": decor.utensil_crock,
    "vase": flowers.vase,
    "water_bottle": carried.water_bottle,
}

__all__ = ["OBJECTS"]
