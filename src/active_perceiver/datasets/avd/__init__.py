"""The Active Vision Dataset (Ammirato et al., ICRA 2017)."""
