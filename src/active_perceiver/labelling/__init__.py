"""Labelling by hand: the page that `scenes label` serves, and how nothing drawn on it is lost."""
