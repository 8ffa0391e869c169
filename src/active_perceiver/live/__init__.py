"""Live searches: the loop of looking and acting, what is shown of it, and what is recorded."""

from active_perceiver.live.search_loop import SearchRecord, StepRecord, search

__all__ = ["StepRecord", "SearchRecord", "search"]
