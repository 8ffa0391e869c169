"""Active Object Perceiver: give a robot a picture of an object; it searches the room and draws a box on it.

An implementation of Ye, Lin, Li, Zheng, Yang, "Active Object Perceiver: Recognition-guided Policy Learning for
Object Searching on Mobile Robots", IROS 2018 (https://arxiv.org/abs/1807.11174).
"""

__version__ = "0.2.0"
