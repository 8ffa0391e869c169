"""Live searches: the loop of looking and acting, what is shown of it, and what is recorded."""

from active_perceiver.live.config import SearchConfig
from active_perceiver.live.search_loop import SearchRecord, StepRecord, search

__all__ = ["SearchConfig", "SearchRecord", "StepRecord", "search"]
