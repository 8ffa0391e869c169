"""Scene dumps of Zhu et al. (ICRA 2017)."""
