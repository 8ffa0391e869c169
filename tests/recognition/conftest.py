from helpers.small import backbone, rng

__all__ = ["backbone", "rng"]
