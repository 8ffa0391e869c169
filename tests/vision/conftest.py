from helpers.small import rng

__all__ = ["rng"]
